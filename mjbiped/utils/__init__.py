"""Valid ranges of user inputs, distributions, files and processes."""
