"""Robustness studies: steps until a fall on random ground, and the greatest disturbances that are survived."""
