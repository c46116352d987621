"""Figures of walks, gaits and studies of them."""
