"""One walk, and many."""
