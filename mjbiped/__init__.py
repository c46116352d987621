"""A laboratory for underactuated biped walking on rough ground.

`walk(controller, terrain)` simulates a biped in MuJoCo or in the hybrid model and returns its record, a `Walk`;
`walk_many` simulates many at once. The control laws are in the package `controllers`, installed with this one.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

# first, because it imports MuJoCo, even if MUJOCO_GL names a missing platform
from mjbiped.rendering import gl as gl  # isort: split

from mjbiped.analysis.compare import Comparison, compare
from mjbiped.analysis.survival import Survival
from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.engines.base import Engine
from mjbiped.engines.hybrid.engine import Hybrid
from mjbiped.engines.mujoco.engine import Mujoco
from mjbiped.errors import GaitError, InputError, MjbipedError, RecordError, RenderError
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.kneed import KneedGait, find_kneed_gait
from mjbiped.gaits.optimised import OptimisedGait, OptimisedKneedGait, find_reference
from mjbiped.gaits.passive import PassiveGait, find_passive_gait
from mjbiped.limit_cycles.basin import basin_of_attraction, basin_of_control
from mjbiped.limit_cycles.bifurcation import bifurcation_diagram, find_cascade
from mjbiped.limit_cycles.periodic import find_periodic_gait
from mjbiped.limit_cycles.return_map import ReturnMap
from mjbiped.records.record import Walk
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.wheel import RimlessWheel
from mjbiped.rollout.walk import WalkInterrupted, WalkStopped, walk
from mjbiped.rollout.walk_many import WalksInterrupted, WalksStopped, walk_many
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.packages import warn_of_hidden_laws
from mjbiped.version import __version__

if TYPE_CHECKING:
    from mjbiped import envs
    from mjbiped.rendering.video import render_frame, render_video

warn_of_hidden_laws()

__all__ = [
    "Comparison",
    "Compass",
    "Disturbances",
    "Engine",
    "Gait",
    "GaitError",
    "Hybrid",
    "InputError",
    "KneedBiped",
    "KneedGait",
    "MjbipedError",
    "Mujoco",
    "OptimisedGait",
    "OptimisedKneedGait",
    "PassiveGait",
    "RecordError",
    "RenderError",
    "ReturnMap",
    "RimlessWheel",
    "ScuffingRule",
    "Survival",
    "Terrain",
    "Walk",
    "WalkInterrupted",
    "WalkStopped",
    "WalksInterrupted",
    "WalksStopped",
    "__version__",
    "basin_of_attraction",
    "basin_of_control",
    "bifurcation_diagram",
    "compare",
    "envs",
    "find_cascade",
    "find_kneed_gait",
    "find_passive_gait",
    "find_periodic_gait",
    "find_reference",
    "render_frame",
    "render_video",
    "walk",
    "walk_many",
]


def __getattr__(name: str) -> Any:
    """Import videos and environments only when they are used."""
    if name in ("render_frame", "render_video"):
        from mjbiped.rendering import video

        return getattr(video, name)
    if name == "envs":
        return importlib.import_module("mjbiped.envs")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
