"""The ground: profiles, presets and terrain files."""
