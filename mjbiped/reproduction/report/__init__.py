"""The page of the reproduction."""
