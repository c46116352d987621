"""Reproduction of the paper's section V: every table and figure, in both engines, beside the paper's own numbers."""
