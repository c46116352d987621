"""Options that several commands share: walk, controller, robot, disturbances, results, video, studies."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection
from dataclasses import fields
from pathlib import Path
from typing import Any

import click

from mjbiped.cli import kinds
from mjbiped.cli.sections import Function, Row, described, options, rows_of, together
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


def gains_of(name: str, robot: Robot | None = None) -> dict[str, object]:
    """Return names and defaults of the settings that `--gain` sets; the others have options of their own."""
    return {key: value for key, value in settings_of(name, robot).items() if key not in (*SHARED, "slope_source")}


def _sentence(text: str) -> str:
    """Return the first sentence of a text."""
    return text.partition(". ")[0].removesuffix(".") + "."


def field_options(section: str, kind: type, *names: str, **defaults: object) -> Callable[[Function], Function]:
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
        rows.append((f"{word}/--no-{word[2:]}" if valid is bool else word, valid, _sentence(texts[name]), default))
    return options(section, *rows)


ADAPTIVE, COMPARISON, MUJOCO = "Adaptive controller", "Comparison controllers", "MuJoCo"
ROBOT, VIDEO = "Robot", "Video"
"""Sections of the help."""


class _Walk:
    """Options of a walk.

    Attributes:
        seed: Seed of random ground.
        steps: End after this many steps; {steps} unless a distance is given.
        distance: End at this position x of the stance foot, m.
        initial: First state: 'gait' (on the limit cycle), 'rest' (legs together, at rest), or q1,q2,dq1,dq2 of stance
            and swing leg from the ground's normal, rad and rad/s; with knees q1,q2,q3,dq1,dq2,dq3.
        controller: 'adaptive' imitates a passive gait on ground of unknown slope; 'passive' applies no torque;
            {built_on} go further, see docs/references.md and docs/feet.md; {compared} are those that the paper compares
            with, see docs/comparison.md. Your own by its class: {forms}, as spread.py:HipSpread.
    """

    seed = domains.SEED
    steps = domains.STEPS
    distance = domains.DISTANCE
    initial = kinds.INITIAL_STATE, "gait"
    controller = kinds.CONTROLLER, DEFAULT_CONTROLLER


_BUILT_ON, _COMPARED = ", ".join(BUILT_ON), ", ".join(COMPARED)
_WALK = rows_of(_Walk, steps=str(DEFAULT_STEPS), built_on=_BUILT_ON, compared=_COMPARED, forms=FORMS)
SEED, _, _, INITIAL, _ = _WALK
walk_options = options("Walk", *_WALK)


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


_PHYSICS = "The physics: MuJoCo's contacts, or the paper's impact map."
engine_option = options("Walk", ("--engine", click.Choice(tuple(ENGINES)), _PHYSICS, DEFAULT_ENGINE))


class _Laws:
    """Options of controllers that are no field of one.

    Attributes:
        imitate_slope_deg: Slope of the passive gait that is imitated; for all but passive.
        reference: Track an optimised gait instead: clearance=X,retraction=no,speed=X,torque_limit=X,friction=X, any of
            them, in m, m/s and N m; for adaptive, limit-cycle, {built_on}.
        initial_slope_estimate_deg: Slope estimate at the start; for the comparison controllers the slope that they are
            given.
        slope_source: The slope that gravity is compensated for: as given at the start, dead reckoned under the stance
            foot, or of the line through both feet; two_point for passivity, local for the others unless given.
    """

    imitate_slope_deg = domains.SLOPE_DEG, SHARED["imitate_slope_deg"]
    reference = kinds.REFERENCE, SHARED["reference"]
    initial_slope_estimate_deg = domains.SLOPE_DEG, SHARED["initial_slope_estimate_deg"]
    slope_source = click.Choice(SLOPE_SOURCES)


IMITATE, REFERENCE, _ESTIMATE, _SOURCE = rows_of(_Laws, built_on=_BUILT_ON)
_GAINS = ("position_gain", "velocity_gain", "adaptation_gain", "replanning_delay", "estimate_update")
_adaptive_options = together(
    options(ADAPTIVE, IMITATE, REFERENCE), field_options(ADAPTIVE, AdaptiveController, *_GAINS)
)
law_options = together(_adaptive_options, options(ADAPTIVE, _ESTIMATE), options(COMPARISON, _SOURCE))


def parameter_options(robots: Collection[str]) -> Callable[[Function], Function]:
    """Return the options of robots' parameters, each in a section of the robots that have it, unless all do."""
    made = []
    for key, names in kinds.OWNERS.items():
        owners = {name: named(name) for name in names if name in robots}
        if owners:
            kind, _ = next(iter(owners.values()))
            defaults = {name: parameters.get(key) for name, (_, parameters) in owners.items()}
            default, *different = dict.fromkeys(defaults.values())
            text, (domain, _) = _sentence(described(kind)[key]), domains.annotated(kind)[key]
            if different:
                text += f"  [default: {', '.join(f'{value} {name}' for name, value in defaults.items())}]"
            section = ROBOT if len(owners) == len(robots) else f"{ROBOT} {', '.join(owners)}"
            made.append(options(section, (f"--{key.replace('_', '-')}", domain, text, None if different else default)))
    return together(*made)


class _Robot:
    """Options of any robot.

    Attributes:
        robot: {robots} Or a .toml file with a kind and parameters as in the record; or an .xml file (MJCF) of a planar
            biped, see docs/exports.md. Options below change single parameters.
    """

    robot = kinds.ROBOT, Compass.kind


_ROBOTS = " ".join(f"'{name}': {str(inspect.getdoc(make)).splitlines()[0]}" for name, make in NAMED.items())
robot_options = together(options(ROBOT, *rows_of(_Robot, robots=_ROBOTS)), parameter_options(NAMED))


class _Disturbed:
    """Options of disturbances, all of which may be repeated.

    Attributes:
        disturb: Noise, delay, weak motors, random pushes, in SI units; may be repeated: {settings}.
            docs/disturbances.md explains them.
        pushes: Push the hip at TIME, s, with IMPULSE, N s, positive forward; may be repeated.
        model_error: Give the controller's model FACTOR times the robot's NAME, such as leg_mass; may be repeated.
    """

    disturb = kinds.SETTING, ()
    pushes = kinds.PUSH, (), "--push pushes"
    model_error = kinds.MODEL_ERROR, ()


_DEFAULTS = {each.name: each.default for each in fields(Disturbances) if each.name != "pushes"}
_SETTINGS = ", ".join(f"{name}={'none' if value is None else f'{value:g}'}" for name, value in _DEFAULTS.items())
disturbance_options = options("Disturbances", *rows_of(_Disturbed, settings=_SETTINGS))

walker_options = together(
    walk_options,
    gain_option("Walk"),
    scuffing_option("Walk"),
    mujoco_options,
    law_options,
    robot_options,
    disturbance_options,
)
"""All options of a walk but the engine."""

# ---- results, for `mjbiped.cli.sections.results` ---------------------------------------------------------------------

_RECORD = "Write the record, an .npz file, which other commands read; or .csv, .parquet or .mcap for other programs."
RECORD: Row = ("--out", kinds.RECORD, _RECORD)
RECORDS: Row = ("--out", kinds.output(".npz"), "Write both records: a.npz gives a_mujoco.npz and a_hybrid.npz.")
DATA: Row = ("--out", kinds.output(".npz"), "Write the data, an .npz file.")
_SIZES = ", ".join(f"{name} {size.inches:g} in" for name, size in WIDTHS.items())
_WIDTHS = f"Width of figures: {_SIZES}; page is for the screen, double and single are columns in print, slide is 16:9."
WIDTH: Row = ("--plot-width", kinds.Width(tuple(WIDTHS)), _WIDTHS, DEFAULT_WIDTH)
PLOT: tuple[Row, ...] = (("--plot", kinds.PLOT, "Write a figure, .png, .pdf or .svg."), WIDTH)
PANELS: Row = ("--panels", kinds.PANELS, "Panels of the figure, as torque,phase; all that have values unless given.")
VIDEO_FILE: Row = ("--video", kinds.VIDEO, "Write a video, .mp4 or .gif; see below.")
JSON: Row = ("--json", bool, "Print the results as JSON instead of a table.")
QUIET: Row = ("--quiet", bool, "Print errors only, and JSON if asked for.")
PRINTED = (JSON, QUIET)

# ---- video -----------------------------------------------------------------------------------------------------------

CAMERAS = ("track", "side", "overview")


class _Video:
    """Options of a video.

    Attributes:
        video_size: Width and height, pixels.
        camera: Camera of the video.
        start: Time of the walk at which the video begins, s.
        stop: Time of the walk at which it ends, s.
        slow_motion: Seconds of video per second of the walk.
        fps: Frames per second.
        hide: Elements to hide, separated by commas: {elements}.
        flags: A visual flag of MuJoCo's to set, such as contactpoint, shadow or wireframe; with no- before it to clear,
            as no-skin; may be repeated.
    """

    video_size = kinds.VIDEO_SIZE, "1280x720"
    camera = click.Choice(CAMERAS), CAMERAS[0]
    start = stop = domains.TIME
    slow_motion = domains.SLOW_MOTION, 1.0
    fps = domains.FPS, 30
    hide = kinds.HIDDEN, ()
    flags = kinds.VISUAL_FLAG, (), "--flag flags"


video_options = options(VIDEO, *rows_of(_Video, elements=f"{', '.join(ELEMENTS)}, or {ALL}"))
"""Options of a video, named as the arguments of `mjbiped.rendering.video.render_video`, `video_size` apart."""

# ---- studies ---------------------------------------------------------------------------------------------------------

study_argument = click.argument("study", type=click.Path(path_type=Path))


class _Study:
    """Options of a study.

    Attributes:
        workers: Number of processes; one for each core unless given.
        scheduler: Run on the workers of this Dask scheduler, such as tcp://host:8786; needs pip install
            'mjbiped[cluster]'.
        fresh: Delete the rows of an earlier run and begin again.
    """

    workers = domains.WORKERS
    scheduler = kinds.Kind("ADDRESS", str)
    fresh = bool


STUDY = rows_of(_Study)
WORKERS = STUDY[0]
_TABLES = "Folder for table and figures; beside STUDY, with its name, unless given."
STUDY_FOLDER: Row = ("--out", kinds.FOLDER, _TABLES)
