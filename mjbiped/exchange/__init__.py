"""Robots, scenes and records in the formats of other programs, and robots from such files."""
