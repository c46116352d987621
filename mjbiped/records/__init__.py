"""Records of walks: columns, files, measures."""
