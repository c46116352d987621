"""What a record tells: comparison, stability."""
