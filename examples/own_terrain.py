"""A terrain of your own from lengths, slopes and steps; the robot on it, as one frame of a video."""

import math

import matplotlib.image

import mjbiped
from controllers import AdaptiveController

robot = mjbiped.Compass()
gait = mjbiped.find_passive_gait(robot, slope=math.radians(2))
segments = [(0.6, 0.0, 0.0), (0.9, 4.0, 0.02), (0.8, 0.0, -0.04), (9.0, -2.0, 0.0)]  # m, degrees downhill, m up
walk = mjbiped.walk(AdaptiveController(robot, gait), mjbiped.Terrain.from_segments(segments), steps=8)
matplotlib.image.imsave("own_terrain.png", mjbiped.render_frame(walk, 3.3))
