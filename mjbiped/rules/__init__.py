"""When feet touch and when walks end."""
