"""Laws for an ankle whose torque a sole bounds: tracking within the bound, a recovery step, and who chooses."""
