"""Interactive reports: a walk or a study as one HTML page."""
