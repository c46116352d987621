"""The viewer: a window that shows a walk under way, or replays a record."""
