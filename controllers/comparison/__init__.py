"""The control laws that the paper compares its own with (section V)."""
