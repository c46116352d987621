"""Validation, files and processes."""
