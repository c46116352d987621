"""A picture of each robot, walking: with the adaptive laws, or passively down the slope of its gait."""

import math

import matplotlib.image

import mjbiped
from controllers import AdaptiveController, KneedController, PassiveController, SupervisedController
from mjbiped.control.registry import make_controller

compass, kneed, footed = mjbiped.Compass(), mjbiped.KneedBiped(), mjbiped.FootedCompass()
straight, bending = mjbiped.Compass3D(), mjbiped.Kneed3D()  # in space
opening = mjbiped.Abducting3D(sole=0.12, sole_width=0.08)
lifting = mjbiped.find_reference(footed, clearance=0.077, retraction=False)
stairs, incline = mjbiped.Terrain.stairs(rise=0.03, first=0.5), mjbiped.Terrain.incline
walks = {
    "compass": (compass, AdaptiveController(compass, mjbiped.find_passive_gait(compass, math.radians(2))), stairs),
    "kneed": (kneed, KneedController(kneed, mjbiped.find_reference(kneed, clearance=0.08)), stairs),
    "footed": (footed, SupervisedController(footed, lifting), stairs),
    "round": (mjbiped.RoundCompass(), PassiveController(), incline(0.5)),
    "round_kneed": (mjbiped.RoundKneed(), PassiveController(), incline(1.0)),
    "wheel": (mjbiped.RimlessWheel(), PassiveController(), incline(5.0)),
    "compass3d": (straight, make_controller("adaptive", straight, {}), mjbiped.Terrain.bumps(rms=0.015, seed=4)),
    "abducting3d": (opening, make_controller("bounded-ankle", opening, {}), mjbiped.Terrain.bumps(rms=0.01, seed=4)),
    "kneed3d": (bending, make_controller("adaptive", bending, {}), incline(1.0, lateral_deg=1.0)),
}
for name, (robot, law, ground) in walks.items():
    engine = "hybrid" if name.endswith("3d") else "mujoco"
    walk = mjbiped.walk(law, ground, robot=robot, engine=engine, steps=5)
    frame = mjbiped.render_frame(walk, 0.58 * walk.end[0], width=480, height=360, hide="all")
    matplotlib.image.imsave(f"robot_{name}.png", frame)
