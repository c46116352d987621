"""The viewer: a window in which the robot walks, or a record is seen again."""
