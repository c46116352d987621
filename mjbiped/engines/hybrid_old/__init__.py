"""The hybrid engine: the paper's equations and impact map."""
