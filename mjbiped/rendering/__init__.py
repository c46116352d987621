"""Pictures and videos of walks."""
