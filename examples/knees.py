"""A biped with knees climbs stairs; its references lift the foot, and no foot passes through the ground."""

import matplotlib.image

import mjbiped
from controllers import KneedController

robot = mjbiped.KneedBiped()
law = KneedController(robot, mjbiped.find_reference(robot, clearance=0.08))
walk = mjbiped.walk(law, mjbiped.Terrain.stairs(rise=0.04, first=0.5), steps=8)
matplotlib.image.imsave("knees.png", mjbiped.render_frame(walk, 3.0))
