"""Steeper slopes make the passive robot limp with two, four, eight steps a cycle, and then without any order."""

import numpy as np

import mjbiped
from mjbiped.plotting.gaits import plot_bifurcation

robot = mjbiped.Compass()
cascade = mjbiped.find_cascade(robot)
slopes = np.radians(np.linspace(2.5, 3.5, 150))
plot_bifurcation(mjbiped.bifurcation_diagram(robot, slopes), cascade, "bifurcation.png")
