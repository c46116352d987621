"""Compilation and integration."""
