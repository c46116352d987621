"""MuJoCo simulations by plain keyword arguments."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from mjbiped.control.controller import Controller
from mjbiped.engines.mujoco.options import Options
from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.terrain.terrain import Terrain

OPTIONS = {field.name for field in fields(Options)}


def make_simulation(controller: Controller, terrain: Terrain, **settings: Any) -> Simulation:
    """A simulation; settings of the engine stand among its own arguments."""
    options = {name: settings.pop(name) for name in [*settings] if name in OPTIONS}
    return Simulation(controller, terrain, options=Options(**options), **settings)
