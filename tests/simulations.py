"""MuJoCo simulations and scenes by plain keyword arguments."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from mjbiped.control.controller import Controller
from mjbiped.engines.mujoco.ground import Ground
from mjbiped.engines.mujoco.options import Options
from mjbiped.engines.mujoco.scene import Scene, compose_scene
from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.robots.robot import Robot
from mjbiped.terrain.terrain import Terrain

OPTIONS = {field.name for field in fields(Options)}


def make_simulation(controller: Controller, terrain: Terrain, **settings: Any) -> Simulation:
    """A simulation; settings of the engine stand among its own arguments."""
    options = {name: settings.pop(name) for name in [*settings] if name in OPTIONS}
    return Simulation(controller, terrain, options=Options(**options), **settings)


def build_scene(
    robot: Robot,
    terrain: Terrain,
    *,
    timestep: float,
    reach: float,
    ground: str = "auto",
    userdata: int = 0,
    scenery: bool = False,
) -> Scene:
    """The scene of a robot on a whole terrain; see `compose_scene`."""
    layout = Ground(terrain, reach=reach, kind=ground)
    return compose_scene(robot, layout, layout.segments, timestep=timestep, userdata=userdata, scenery=scenery)
