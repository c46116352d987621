"""One walk in both engines: the paper's equations and MuJoCo's contacts side by side."""

import math

import mjbiped
from controllers import AdaptiveController
from mjbiped.plotting.comparison import plot_comparison

robot = mjbiped.Compass()
gait = mjbiped.find_passive_gait(robot, slope=math.radians(2))
comparison = mjbiped.compare(AdaptiveController(robot, gait), mjbiped.Terrain.mixed(), steps=12)
plot_comparison(comparison, "two_engines.png")
