"""Options that several commands share: walk, controller, robot, disturbances, results, video, studies."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Collection
from dataclasses import fields
from pathlib import Path
from typing import Any

import click

from mjbiped.cli import kinds
from mjbiped.cli.sections import Function, Row, options, together
from mjbiped.control.loading import FORMS
from mjbiped.control.registry import DEFAULT_CONTROLLER, SHARED, controller_names, settings_of
from mjbiped.control.settings import shown_defaults
from mjbiped.controllers import AdaptiveController
from mjbiped.controllers.comparison.known_slope import SLOPE_SOURCES
from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.engines.mujoco.options import Options
from mjbiped.engines.names import DEFAULT_ENGINE, ENGINES
from mjbiped.engines.plan import DEFAULT_STEPS
from mjbiped.plotting.width import DEFAULT_WIDTH, WIDTHS
from mjbiped.rendering.look import ALL, ELEMENTS
from mjbiped.robots.compass import Compass
from mjbiped.robots.kinds import NAMED, named
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.utils import domains

COMPARED = ("passivity", "energy-constraint", "kinetic-energy", "limit-cycle")  # in the paper
BUILT_ON = tuple(name for name in controller_names() if name not in ("adaptive", "passive", *COMPARED))
"""Other registered controllers: those of this project build on the adaptive one."""


def gains_of(name: str, robot: Robot | None = None) -> dict[str, Any]:
    """Return names and defaults of the settings that `--gain` sets; the others have options of their own."""
    return {key: value for key, value in settings_of(name, robot).items() if key not in (*SHARED, "slope_source")}


def described(kind: type) -> dict[str, str]:
    """Return the first sentence about each field in the docstring of a dataclass and its bases."""
    found: dict[str, str] = {}
    for each in reversed(kind.__mro__):
        attributes = inspect.cleandoc(each.__doc__ or "").partition("Attributes:\n")[2].partition("\n\n")[0]
        entries = re.findall(r"^ {4}(\w+): (.+(?:\n {8}.+)*)", attributes, re.MULTILINE)
        found |= {name: " ".join(text.split()).partition(". ")[0].removesuffix(".") + "." for name, text in entries}
    return found


def field_options(section: str, kind: type, *names: str, **defaults: Any) -> Callable[[Function], Function]:
    """Return options that set fields of a dataclass, whose annotations say what is valid, and whose docstring why.

    Args:
        section: Section of the help.
        kind: The dataclass.
        *names: Fields with the defaults that they have there.
        **defaults: Other fields, with their defaults.
    """
    texts, domain_of = described(kind), domains.annotated(kind)
    rows: list[Row] = []
    for name, default in {**{name: getattr(kind, name) for name in names}, **defaults}.items():
        word = f"--{name.replace('_', '-')}"
        valid: Any = bool
        if not isinstance(default, bool):
            domain, optional = domain_of[name]
            valid = kinds.optional(domain) if optional and default is not None else domain
        rows.append((f"{word}/--no-{word[2:]}" if valid is bool else word, valid, texts[name], default))
    return options(section, *rows)


ADAPTIVE, COMPARISON, MUJOCO = "Adaptive controller", "Comparison controllers", "MuJoCo"
ROBOT, VIDEO = "Robot", "Video"
"""Sections of the help."""

SEED: Row = ("--seed", domains.SEED, "Seed of random ground.")
INITIAL: Row = (
    "--initial",
    kinds.INITIAL_STATE,
    "First state: 'gait' (on the limit cycle), 'rest' (legs together, at rest), or q1,q2,dq1,dq2 of stance and "
    "swing leg from the ground's normal, rad and rad/s; with knees q1,q2,q3,dq1,dq2,dq3.",
    "gait",
)
walk_options = options(
    "Walk",
    SEED,
    ("--steps", domains.STEPS, f"End after this many steps; {DEFAULT_STEPS} unless a distance is given."),
    ("--distance", domains.DISTANCE, "End at this position x of the stance foot, m."),
    INITIAL,
    (
        "--controller",
        kinds.CONTROLLER,
        "'adaptive' imitates a passive gait on ground of unknown slope; 'passive' applies no torque; "
        f"{', '.join(BUILT_ON)} go further, see docs/references.md and docs/feet.md; "
        f"{', '.join(COMPARED)} are those that the paper compares with, see docs/comparison.md. Your own by its class: "
        f"{FORMS}, as spread.py:HipSpread.",
        DEFAULT_CONTROLLER,
    ),
)


def gain_option(section: str) -> Callable[[Function], Function]:
    """Return the option that sets a field of the controller."""
    usual = gains_of("adaptive")
    known = [f"adaptive: {shown_defaults(usual)}"]
    for name in (*BUILT_ON, *COMPARED):
        gains = gains_of(name)
        more = {key: value for key, value in gains.items() if key not in usual}
        builds = usual.keys() <= gains.keys()
        known.append(f"{name}: {'those, and ' if builds else ''}{shown_defaults(more if builds else gains) or 'none'}")
    text = f"Set a field of the controller, may be repeated; {'; '.join(known)}; your own: its dataclass fields."
    return options(section, ("--gain", kinds.SETTING, text, ()))


mujoco_options = field_options(
    MUJOCO, Options, "timestep", "contact_timestep", "control_period", "lands", "stance_knee"
)


def scuffing_option(section: str) -> Callable[[Function], Function]:
    """Return the option of the scuffing rule: which scuffs are ignored, and which steps are long enough."""
    text = "Leg lengths ahead of the stance foot from which the swing foot may touch the ground; steps must be longer."
    return options(section, ("--scuffing-reach", domains.REACH, text, ScuffingRule.reach))


engine_option = options(
    "Walk",
    (
        "--engine",
        click.Choice(tuple(ENGINES)),
        "The physics: MuJoCo's contacts, or the paper's impact map.",
        DEFAULT_ENGINE,
    ),
)

REFERENCE: Row = (
    "--reference",
    kinds.REFERENCE,
    "Track an optimised gait instead: clearance=X,retraction=no,speed=X,torque_limit=X,friction=X, any of them, in m, "
    f"m/s and N m; for adaptive, limit-cycle, {', '.join(BUILT_ON)}.",
    SHARED["reference"],
)

IMITATE: Row = (
    "--imitate-slope-deg",
    domains.SLOPE_DEG,
    "Slope of the passive gait that is imitated; for all but passive.",
    SHARED["imitate_slope_deg"],
)

adaptive_options = together(
    options(ADAPTIVE, IMITATE, REFERENCE),
    field_options(
        ADAPTIVE,
        AdaptiveController,
        "position_gain",
        "velocity_gain",
        "adaptation_gain",
        "replanning_delay",
        "estimate_update",
    ),
    options(
        ADAPTIVE,
        (
            "--initial-slope-estimate-deg",
            domains.SLOPE_DEG,
            "Slope estimate at the start; for the comparison controllers the slope that they are given.",
            SHARED["initial_slope_estimate_deg"],
        ),
    ),
)

comparison_options = options(
    COMPARISON,
    (
        "--slope-source",
        click.Choice(SLOPE_SOURCES),
        "The slope that gravity is compensated for: as given at the start, dead reckoned under the stance foot, or of "
        "the line through both feet; two_point for passivity, local for the others unless given.",
    ),
)


def parameter_options(robots: Collection[str]) -> Callable[[Function], Function]:
    """Return the options of robots' parameters, each in a section of the robots that have it, unless all do."""
    made = []
    for key, names in kinds.OWNERS.items():
        owners = {name: named(name) for name in names if name in robots}
        if owners:
            kind, _ = next(iter(owners.values()))
            defaults = {name: parameters.get(key) for name, (_, parameters) in owners.items()}
            default, *different = dict.fromkeys(defaults.values())
            text, (domain, _) = described(kind).get(key, ""), domains.annotated(kind)[key]
            if different:
                text += f"  [default: {', '.join(f'{value} {name}' for name, value in defaults.items())}]"
            section = ROBOT if len(owners) == len(robots) else f"{ROBOT} {', '.join(owners)}"
            made.append(options(section, (f"--{key.replace('_', '-')}", domain, text, None if different else default)))
    return together(*made)


ROBOTS = " ".join(f"'{name}': {str(inspect.getdoc(make)).splitlines()[0]}" for name, make in NAMED.items())
KIND: Row = (
    "--robot",
    kinds.ROBOT,
    f"{ROBOTS} Or a .toml file with a kind and parameters as in the record; or an .xml file (MJCF) of a planar biped, "
    "see docs/exports.md. Options below change single parameters.",
    Compass.kind,
)
robot_options = together(options(ROBOT, KIND), parameter_options(NAMED))

_DISTURBANCES = ", ".join(
    f"{field.name}={'none' if field.default is None else f'{field.default:g}'}"
    for field in fields(Disturbances)
    if field.name != "pushes"
)

disturbance_options = options(
    "Disturbances",
    (
        "--disturb",
        kinds.SETTING,
        f"Noise, delay, weak motors, random pushes, in SI units; may be repeated: {_DISTURBANCES}. "
        "docs/disturbances.md explains them.",
        (),
    ),
    (
        "--push pushes",
        kinds.PUSH,
        "Push the hip at TIME, s, with IMPULSE, N s, positive forward; may be repeated.",
        (),
    ),
    (
        "--model-error",
        kinds.MODEL_ERROR,
        "Give the controller's model FACTOR times the robot's NAME, such as leg_mass; may be repeated.",
        (),
    ),
)

walker_options = together(
    walk_options,
    gain_option("Walk"),
    scuffing_option("Walk"),
    mujoco_options,
    adaptive_options,
    comparison_options,
    robot_options,
    disturbance_options,
)
"""All options of a walk but the engine."""

# ---- results, for `mjbiped.cli.sections.results` ---------------------------------------------------------------------

RECORD: Row = (
    "--out",
    kinds.RECORD,
    "Write the record, an .npz file, which other commands read; or .csv, .parquet or .mcap for other programs.",
)
RECORDS: Row = ("--out", kinds.output(".npz"), "Write both records: a.npz gives a_mujoco.npz and a_hybrid.npz.")
DATA: Row = ("--out", kinds.output(".npz"), "Write the data, an .npz file.")
_WIDTHS = ", ".join(f"{name} {size.inches:g} in" for name, size in WIDTHS.items())
WIDTH: Row = (
    "--plot-width",
    kinds.Width(tuple(WIDTHS)),
    f"Width of figures: {_WIDTHS}; page is for the screen, double and single are columns in print.",
    DEFAULT_WIDTH,
)
PLOT: tuple[Row, ...] = (("--plot", kinds.PLOT, "Write a figure, .png, .pdf or .svg."), WIDTH)
VIDEO_FILE: Row = ("--video", kinds.VIDEO, "Write a video, .mp4 or .gif; see below.")
JSON: Row = ("--json", bool, "Print the results as JSON instead of a table.")
QUIET: Row = ("--quiet", bool, "Print errors only, and JSON if asked for.")
PRINTED = (JSON, QUIET)

# ---- video -----------------------------------------------------------------------------------------------------------

CAMERAS = ("track", "side", "overview")
video_options = options(
    VIDEO,
    ("--video-size", kinds.VIDEO_SIZE, "Width and height, pixels.", "1280x720"),
    ("--camera", click.Choice(CAMERAS), "Camera of the video.", CAMERAS[0]),
    ("--start", domains.TIME, "Time of the walk at which the video begins, s."),
    ("--stop", domains.TIME, "Time of the walk at which it ends, s."),
    ("--slow-motion", domains.SLOW_MOTION, "Seconds of video per second of the walk.", 1.0),
    ("--fps", domains.FPS, "Frames per second.", 30),
    ("--hide", kinds.HIDDEN, f"Elements to hide, separated by commas: {', '.join(ELEMENTS)}, or {ALL}.", ()),
    (
        "--flag flags",
        kinds.VISUAL_FLAG,
        "A visual flag of MuJoCo's to set, such as contactpoint, shadow or wireframe; with no- before it to clear, as "
        "no-skin; may be repeated.",
        (),
    ),
)
"""Options of a video, named as the arguments of `mjbiped.rendering.video.render_video`, `video_size` apart."""

# ---- studies ---------------------------------------------------------------------------------------------------------

study_argument = click.argument("study", type=click.Path(path_type=Path))
WORKERS: Row = ("--workers", domains.WORKERS, "Number of processes; one for each core unless given.")
STUDY: tuple[Row, ...] = (
    WORKERS,
    (
        "--scheduler",
        kinds.Kind("ADDRESS", str),
        "Run on the workers of this Dask scheduler, such as tcp://host:8786; needs pip install 'mjbiped[cluster]'.",
    ),
    ("--fresh", bool, "Delete the rows of an earlier run and begin again."),
)
STUDY_FOLDER: Row = (
    "--out",
    kinds.Folder(),
    "Folder for table and figures; beside STUDY, with its name, unless given.",
)
