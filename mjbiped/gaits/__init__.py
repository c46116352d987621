"""Passive gaits and references."""
