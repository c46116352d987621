"""Studies of many walks, as a file describes them."""
