"""Planar mechanisms in motion: the linkage, what holds it, and the integrator."""
