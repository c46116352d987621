from . import envs
from .analysis.compare import Comparison, compare
from .analysis.survival import Survival
from .disturbances.disturbances import Disturbances
from .engines.base import Engine
from .engines.hybrid.engine import Hybrid
from .engines.mujoco.engine import Mujoco
from .errors import GaitError, InputError, MjbipedError, RecordError, RenderError
from .gaits.gait import Gait
from .gaits.kneed import KneedGait, find_kneed_gait
from .gaits.optimised import OptimisedGait, OptimisedKneedGait, find_reference
from .gaits.passive import PassiveGait, find_passive_gait
from .gaits.space import find_gait_in_space
from .limit_cycles.basin import basin_of_attraction, basin_of_control
from .limit_cycles.bifurcation import bifurcation_diagram, find_cascade
from .limit_cycles.lateral import lateral_basin
from .limit_cycles.periodic import find_periodic_gait
from .limit_cycles.return_map import ReturnMap
from .plotting.comparison import plot_comparison, plot_stability, plot_survival
from .plotting.gait import plot_gait
from .plotting.gaits import plot_basins, plot_bifurcation, plot_multipliers, plot_return_map
from .plotting.lateral import plot_lateral_basins
from .records.record import Walk
from .rendering.video import render_frame, render_video
from .robots.compass import Compass
from .robots.footed import FootedCompass
from .robots.kneed import KneedBiped
from .robots.round import RimlessWheel, RoundCompass, RoundKneed
from .robots.three_d import Abducting3D, Compass3D, Kneed3D
from .rollout.walk import WalkInterrupted, WalkStopped, walk
from .rollout.walk_many import WalksInterrupted, WalksStopped, walk_many
from .rules.scuffing import ScuffingRule
from .terrain.terrain import Terrain
from .version import __version__

__all__ = [
    "Abducting3D",
    "Comparison",
    "Compass",
    "Compass3D",
    "Disturbances",
    "Engine",
    "FootedCompass",
    "Gait",
    "GaitError",
    "Hybrid",
    "InputError",
    "Kneed3D",
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
    "RoundCompass",
    "RoundKneed",
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
    "find_gait_in_space",
    "find_kneed_gait",
    "find_passive_gait",
    "find_periodic_gait",
    "find_reference",
    "lateral_basin",
    "plot_basins",
    "plot_bifurcation",
    "plot_comparison",
    "plot_gait",
    "plot_lateral_basins",
    "plot_multipliers",
    "plot_return_map",
    "plot_stability",
    "plot_survival",
    "render_frame",
    "render_video",
    "walk",
    "walk_many",
]
