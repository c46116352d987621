"""The adaptive controller walks over slopes and steps that it does not know; the figure shows what it felt and did."""

import math

import mjbiped
from controllers import AdaptiveController

robot = mjbiped.Compass()
gait = mjbiped.find_passive_gait(robot, slope=math.radians(2))
walk = mjbiped.walk(AdaptiveController(robot, gait), mjbiped.Terrain.mixed(), steps=20)
print(walk.outcome, walk.cost_of_transport)
walk.plot("first_walk.png")
