"""The compass biped whose feet are bodies."""
