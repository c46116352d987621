"""From which first states the passive robot finds its gait: the basin of attraction on a slope of 2 degrees."""

import math

import numpy as np

import mjbiped
from mjbiped.plotting.gaits import plot_basins

stance, swing = np.linspace(0.6, 1.8, 61), np.linspace(-1.5, 3.0, 61)  # rates after the first touchdown, rad/s
basin = mjbiped.basin_of_attraction(mjbiped.Compass(), math.radians(2), stance_rates=stance, swing_rates=swing)
plot_basins([basin], "basin.png")
