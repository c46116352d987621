"""A laboratory for underactuated biped walking on rough ground.

One controller, one terrain, one record: `walk(controller, terrain)` lets a compass biped walk in MuJoCo and returns a
`Walk`; `walk_many` lets many walk at once. Control laws are in the package `controllers`, which is installed beside
this one.
"""

from mjbiped import gl as gl  # first: it imports MuJoCo, also where MUJOCO_GL names a platform that is not there
from mjbiped.basin import basin_of_attraction, basin_of_control
from mjbiped.bifurcation import bifurcation_diagram, find_cascade
from mjbiped.compare import Comparison, compare
from mjbiped.compass import Compass
from mjbiped.continuation import find_periodic_gait
from mjbiped.errors import GaitError, InputError, MjbipedError, RecordError, RenderError
from mjbiped.gait import Gait, find_passive_gait
from mjbiped.record import Walk
from mjbiped.return_map import ReturnMap
from mjbiped.scuffing import ScuffingRule
from mjbiped.terrain import Terrain
from mjbiped.version import __version__
from mjbiped.walk import WalkInterrupted, WalkStopped, walk
from mjbiped.walk_many import WalksInterrupted, WalksStopped, walk_many

__all__ = [
    "Comparison",
    "Compass",
    "Gait",
    "GaitError",
    "InputError",
    "MjbipedError",
    "RecordError",
    "RenderError",
    "ReturnMap",
    "ScuffingRule",
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
    "find_cascade",
    "find_passive_gait",
    "find_periodic_gait",
    "walk",
    "walk_many",
]
