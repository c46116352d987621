"""The robot is pushed back and recovers: its figure shows the push in torques and phase portrait."""

import math

import mjbiped
from controllers import AdaptiveController

robot = mjbiped.Compass()
gait = mjbiped.find_passive_gait(robot, slope=math.radians(2))
push = mjbiped.Disturbances(pushes=((4.0, -2.0),))  # time s, impulse N s
walk = mjbiped.walk(AdaptiveController(robot, gait), mjbiped.Terrain.level(), steps=14, disturbances=push)
walk.plot("push.png", panels=("phase", "torque"))
