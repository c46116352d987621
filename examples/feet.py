"""A robot whose feet have mass climbs stairs; the white ball is the centre of pressure under the sole."""

import matplotlib.image

import mjbiped
from controllers import SupervisedController

robot = mjbiped.FootedCompass()
law = SupervisedController(robot, mjbiped.find_reference(robot, clearance=0.077, retraction=False))
walk = mjbiped.walk(law, mjbiped.Terrain.stairs(rise=0.04, first=0.5), steps=8)
matplotlib.image.imsave("feet.png", mjbiped.render_frame(walk, 3.6))
