"""Return maps, periodic gaits and basins."""
