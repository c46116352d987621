"""Robustness as a statistic: steps until a fall on random ground, and the greatest disturbances that are survived."""
