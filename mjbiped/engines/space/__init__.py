"""Walks of robots in space, in both kinds of physics."""
