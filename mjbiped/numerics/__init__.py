"""Machine code: how it is made and kept, and memory that plain Python shares with it."""
