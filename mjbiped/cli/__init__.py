"""The command `mjbiped`."""
