"""Functions that simulate one walk or many."""
