"""Callbacks as machine code."""
