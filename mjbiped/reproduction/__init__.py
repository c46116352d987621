"""Section V of the paper again: every table and figure, in both engines, beside the paper's own numbers."""
