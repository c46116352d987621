"""Laws for an ankle whose torque a sole bounds: tracking within the bound, recovery steps, and their supervisor."""
