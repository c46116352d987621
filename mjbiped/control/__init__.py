"""What a controller is to an engine."""
