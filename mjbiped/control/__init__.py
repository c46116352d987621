"""The contract between controllers and engines."""
