"""The engines that make a robot walk."""
