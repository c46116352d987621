"""Scenes of MuJoCo: all numbers in them, and which ground is built about a place."""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from simulations import UNEQUAL

import mjbiped
from mjbiped import Terrain
from mjbiped.control.controller import Unpowered
from mjbiped.engines.mujoco.ground import Ground
from mjbiped.engines.mujoco.options import Options
from mjbiped.engines.mujoco.scene import scene_spec
from mjbiped.engines.mujoco.scenery import add_section
from mjbiped.engines.mujoco.setup import windows_of
from mjbiped.engines.mujoco.surface import add_surface
from mjbiped.engines.plan import Terms, make_plan
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule

ROBOTS: dict[str, Robot] = {
    robot.kind: robot
    for robot in (
        mjbiped.Compass(), mjbiped.FootedCompass(), replace(UNEQUAL, sole=(0.1, 0.05)), mjbiped.RoundCompass(),
        mjbiped.RoundKneed(), mjbiped.RimlessWheel(),
        mjbiped.Compass3D(4.0, 3.0, 0.4, 0.45, sole=(0.1, 0.1), sole_width=0.08),
        mjbiped.Abducting3D(), mjbiped.Kneed3D(),
    )
}  # fmt: skip
_STEEP = Terrain.from_segments([(0.6, -6.0), (5.0, 3.0, 0.05), (2.0, 4.0, -0.1)])
GROUNDS = {
    "mixed": Terrain.mixed(), "risers": _STEEP, "bumps": Terrain.preset("bumps", rms=0.01, seed=3),
    "to the side": Terrain.preset("incline", slope_deg=2, lateral_deg=3), "many": Terrain.random(seed=3),
    "down": Terrain.incline(4.0),
    "ridges": Terrain((0.0, 0.5, 1.0, 1.5), (0.0, 0.0, -0.2, -0.1), (0.0, math.atan(0.4), math.atan(-0.2), 0.5)),
}  # fmt: skip
_PARTS = ("geoms", "meshes", "hfields", "bodies", "joints", "sites", "pairs", "tendons", "actuators", "sensors")


def of_spec(spec: Any) -> dict[str, Any]:
    """All floating-point numbers of a scene that is not compiled yet, by the kind of its parts."""
    return {part: [number for each in getattr(spec, part) for number in _numbers_of(each)] for part in _PARTS}


def _numbers_of(part: Any) -> Iterator[float]:
    for name in sorted(name for name in dir(part) if not name.startswith("_")):
        value = getattr(part, name)
        if isinstance(value, float | np.ndarray) or type(value).__name__ in ("MjDoubleVec", "MjFloatVec"):
            yield from np.ravel(np.asarray(value, dtype=np.float64)).tolist()


def scene(robot: str, ground: str, kind: str = "auto") -> dict[str, Any]:
    """A robot's scene, and what is seen of the ground."""
    biped, terrain = ROBOTS[robot], GROUNDS[ground]
    layout = Ground(terrain, reach=6.0, kind=kind, half_width=2.0)
    pieces = layout.window(1.0, 4.0 * biped.leg_length, biped.leg_length)
    spec = scene_spec(biped, layout, pieces, timestep=1e-4)
    if "hip_y" in biped.places:
        ends = add_surface(spec, layout, pieces, biped.leg_length, 1.0)
        return {**of_spec(spec), "sight": ends}
    add_section(spec, layout, pieces, biped.leg_length)
    return of_spec(spec)


def windows() -> dict[str, Any]:
    """Pieces of long grounds that are built about a place, and between which places these have all of the ground."""
    terms = Terms(mjbiped.Mujoco(), None, 20.0, mjbiped.Compass(), None, ScuffingRule())
    drawn = (Terrain.random(seed=5, segment_length=(0.04, 0.4)), Terrain.random(roughness=1e-3, spacing=0.12))
    plans = [make_plan(terms, Unpowered(), ground, "rest") for ground in drawn]
    built = [windows_of(plan, Options(), 400, userdata=0, scenery=False) for plan in plans]
    scenes, seen = [each.about(x) for each in built for x in (0.0, 7.0, 19.0)], ((0.0, 0.3), (7.0, 2.0), (15.0, 0.3))
    pieces = [piece.segments for each in built for x, length in seen for piece in each.ground.window(x, 1.5, length)]
    return {
        "pieces": [(each.start, each.stop) for each in pieces],
        "scenes": [(each.start, each.end, *each.inside) for each in scenes],
    }
