"""The ground: what it is, and files of it."""
