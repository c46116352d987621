"""Options that several commands share: walk, controller, robot, disturbances, video, studies."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated

import click

import mjbiped
from mjbiped.cli.commands import Choice, Option, filled, number, options_of, output, pair
from mjbiped.control.loading import FORMS, shown_defaults
from mjbiped.control.registry import DEFAULT_CONTROLLER, SHARED, controller_names, settings_of
from mjbiped.controllers import AdaptiveController
from mjbiped.controllers.comparison.known_slope import SLOPE_SOURCES
from mjbiped.engines.base import ENGINES
from mjbiped.engines.mujoco.options import Options
from mjbiped.engines.plan import DEFAULT_STEPS, INITIAL_STATES
from mjbiped.errors import InputError
from mjbiped.exchange import MODULES
from mjbiped.rendering import ALL, ELEMENTS, SUFFIXES, look
from mjbiped.robots.compass import Compass
from mjbiped.robots.kinds import NAMED
from mjbiped.robots.robot import Robot
from mjbiped.utils import domains
from mjbiped.utils.domains import Words, parse_number

COMPARED = ("passivity", "energy-constraint", "kinetic-energy", "limit-cycle")  # in the paper
BUILT_ON = tuple(name for name in controller_names() if name not in ("adaptive", "passive", *COMPARED))
"""Other registered controllers: those of this project build on the adaptive one."""

CAMERAS = ("track", "side", "overview")

ENGINE = Words(tuple(ENGINES))

MUJOCO = ("timestep", "contact_timestep", "control_period", "lands", "stance_knee")
"""Settings of the engine `mujoco` that are options."""

_GAINS = ("position_gain", "velocity_gain", "adaptation_gain", "replanning_delay", "estimate_update")

LAW = (*SHARED, "slope_source", *_GAINS)
"""Settings of controllers that are options."""


def _initial_state(value: str) -> str | tuple[float, ...]:
    if value in INITIAL_STATES:
        return value
    return tuple(domains.check_states("", [parse_number(part) for part in value.split(",")], (None,)).tolist())


def _push(value: str) -> tuple[float, float]:
    time, impulse = pair(value, ":")
    return number(time, domains.TIME), number(impulse, domains.PUSH)


def _model_error(value: str) -> tuple[str, float]:
    name, factor = pair(value)
    return name, number(factor, domains.MODEL_ERROR)


def _video_size(value: str) -> str:
    if any(number(part, domains.PIXELS) % 2 for part in pair(value.lower(), "x")):  # H.264 accepts even numbers only
        raise InputError("odd")
    return value.lower()


def _panels(value: str) -> tuple[str, ...]:
    from mjbiped.records.signals import check_panels  # for this option alone

    return check_panels(value.split(","))


FILE = click.Path(path_type=Path)
FOLDER = click.Path(file_okay=False, path_type=Path)  # which need not exist
FOLDER.metavar = "FOLDER"  # type: ignore[attr-defined]  # as `Choice` has it
RECORD, DATA, PLOT, VIDEO = output(".npz", *MODULES), output(".npz"), output(".png", ".pdf", ".svg"), output(*SUFFIXES)
PANELS = Choice("NAMES", _panels)
_SETTING = Choice("NAME=VALUE", pair, "NAME=VALUE, as gain=10")
_STATE = f"{', '.join(map(repr, INITIAL_STATES))} or four numbers q1,q2,dq1,dq2 (rad, rad/s)"
_FACTOR = f"NAME=FACTOR, as leg_mass=1.2, with {domains.MODEL_ERROR.words}"
_PIXELS = f"WIDTHxHEIGHT, even pixels from {domains.PIXELS.low} to {domains.PIXELS.high} each, as 1280x720"


def _all_gains() -> str:
    """Say what `--gain` sets; other settings have options of their own."""

    def gains_of(name: str) -> dict[str, object]:
        return {key: value for key, value in settings_of(name).items() if key not in (*SHARED, "slope_source")}

    usual = gains_of("adaptive")
    known = [f"adaptive: {shown_defaults(usual)}"]
    for name in (*BUILT_ON, *COMPARED):
        gains = gains_of(name)
        more = {key: value for key, value in gains.items() if key not in usual}
        builds = usual.keys() <= gains.keys()
        inherited = "those of adaptive, and " if builds else ""
        known.append(f"{name}: {inherited}{shown_defaults(more if builds else gains) or 'none'}")
    return "; ".join(known)


DISTURBANCES = {each.name: each.default for each in fields(mjbiped.Disturbances) if each.name != "pushes"}
"""Names and defaults of what `--disturb` sets."""


@filled(
    steps=DEFAULT_STEPS,
    built_on=", ".join(BUILT_ON),
    compared=", ".join(COMPARED),
    forms=FORMS,
    gains=_all_gains(),
    settings=", ".join(f"{name}={'none' if value is None else f'{value:g}'}" for name, value in DISTURBANCES.items()),
    robots=" ".join(f"'{name}': {str(inspect.getdoc(make)).splitlines()[0]}" for name, make in NAMED.items()),
)
class _Walk:
    """Options of walks and their parts.

    Walk:
        seed: Seed of random ground.
        steps: End after this many steps; {steps} unless a distance is given.
        distance: End at this position x of the stance foot, m.
        initial: First state: 'gait' (on the limit cycle), 'rest' (legs together, at rest), or q1,q2,dq1,dq2 of stance
            and swing leg from the ground's normal, rad and rad/s; with knees q1,q2,q3,dq1,dq2,dq3.
        controller: 'adaptive' imitates a passive gait on ground of unknown slope; 'passive' applies no torque;
            {built_on} are further controllers of this project, see the pages "references", "feet" and "environments" of
            the documentation; {compared} are those that the paper compares with, see the page "comparison". Name your
            own controller by its class: {forms}, as spread.py:HipSpread.
        gain: Set a field of the controller, may be repeated; {gains}; your own: its dataclass fields.
        scuffing_reach: Least distance, in leg lengths ahead of the stance foot, at which the swing foot can touch the
            ground; each step must be longer.

    Adaptive controller:
        imitate_slope_deg: Slope, degrees, of the passive gait that the controller tracks; for all but passive.
        reference: Track an optimised gait instead of a passive gait. GOAL is one or more of clearance=X (m),
            retraction=no, speed=X (m/s), torque_limit=X (N m) and friction=X, separated by commas; for adaptive,
            limit-cycle, {built_on}.
        initial_slope_estimate_deg: Slope estimate at the start, degrees; comparison controllers take this value for the
            slope.

    Comparison controllers:
        slope_source: Slope for which the controller compensates gravity: 'none', the slope given at the start; 'local',
            the slope under the stance foot by dead reckoning; 'two_point', the slope of the line through both feet. By
            default 'two_point' for passivity, 'local' for the others.

    Robot:
        robot: {robots} Or a .toml file with kind = "NAME" and parameters; or an .xml file (MJCF) of a planar biped,
            see the page "exports" of the documentation. Options below change single parameters.

    Disturbances:
        disturb: Noise, delay, weak motors, random pushes, in SI units; may be repeated: {settings}. The page
            "disturbances" of the documentation explains them.
        push: Push the hip at TIME, s, with IMPULSE, N s, positive forward; may be repeated.
        model_error: Give the controller's model FACTOR times the robot's NAME, such as leg_mass; may be repeated.
    """

    seed: Annotated[int | None, domains.SEED] = None
    steps: Annotated[int | None, domains.STEPS] = None
    distance: Annotated[float | None, domains.DISTANCE] = None
    initial: Annotated[str, Choice("STATE", _initial_state, _STATE)] = "gait"
    controller: Annotated[str, Choice("NAME")] = DEFAULT_CONTROLLER
    gain: Annotated[tuple[str, ...], _SETTING] = ()
    scuffing_reach: Annotated[float, domains.REACH] = mjbiped.ScuffingRule.reach
    imitate_slope_deg: Annotated[float, domains.SLOPE_DEG] = SHARED["imitate_slope_deg"]
    reference: Annotated[str | None, Choice("GOAL")] = SHARED["reference"]
    initial_slope_estimate_deg: Annotated[float, domains.SLOPE_DEG] = SHARED["initial_slope_estimate_deg"]
    slope_source: Annotated[str | None, Words(SLOPE_SOURCES)] = None
    robot: Annotated[str, Choice("NAME|FILE")] = Compass.kind
    disturb: Annotated[tuple[str, ...], _SETTING] = ()
    push: Annotated[tuple[str, ...], Choice("TIME:IMPULSE", _push, "TIME:IMPULSE in s and N s, as 2:-5")] = ()
    model_error: Annotated[tuple[str, ...], Choice("NAME=FACTOR", _model_error, _FACTOR)] = ()


def parameter_options(robots: Mapping[str, Callable[[], Robot]]) -> Iterator[Option]:
    """Make the options of robots' parameters, each in a section of the robots that have it, unless all do."""
    made = {name: make() for name, make in robots.items()}
    for key in dict.fromkeys(key for robot in made.values() for key in robot.parameters()):
        owners = {name: robot for name, robot in made.items() if key in robot.parameters()}
        # the inertias of rods follow masses and lengths
        usual = {name: None if key.endswith("_inertia") else getattr(robot, key) for name, robot in owners.items()}
        default, *different = dict.fromkeys(usual.values())
        section = "Robot" if len(owners) == len(robots) else f"Robot {', '.join(owners)}"
        kind = type(next(iter(owners.values())))
        [option] = options_of(kind, section, **{key: None if different else default})
        if different:
            option.help = f"{option.help}  [default: {', '.join(f'{value} {name}' for name, value in usual.items())}]"
        yield option


SCENE = options_of(_Walk, "", "seed", "initial")
_PARAMETERS = [*parameter_options(NAMED)]
PARAMETERS = [str(each.name) for each in _PARAMETERS]
"""Parameters of robots."""
ROBOT = [*options_of(_Walk, "", "robot"), *_PARAMETERS]
MAP_ROBOT = [*options_of(_Walk, "Map", "scuffing_reach"), *ROBOT]
MAP_LAW = options_of(_Walk, "Map", "gain") + options_of(_Walk, "", "imitate_slope_deg", "reference")
"""Options of the controller of a map."""

WALKER = [
    *options_of(_Walk),
    *options_of(AdaptiveController, "Adaptive controller", *_GAINS),
    *options_of(Options, "MuJoCo", *MUJOCO),
    *_PARAMETERS,
]
"""All options of a walk but the engine."""


@filled(elements=", ".join(ELEMENTS), every=ALL)
@dataclass
class Video:
    """How a video is to look.

    Video:
        video_size: Width and height, pixels.
        camera: Camera of the video.
        start: Time of the walk at which the video begins, s.
        stop: Time of the walk at which it ends, s.
        slow_motion: Seconds of video per second of the walk.
        fps: Frames per second.
        hide: Elements to hide, separated by commas: {elements}, or {every}.
        flags: A visual flag of MuJoCo's to set, such as contactpoint, shadow or wireframe; with no- before it to clear,
            as no-skin; may be repeated.
    """

    video_size: Annotated[str, Choice("WxH", _video_size, _PIXELS)] = "1280x720"
    camera: Annotated[str, Words(CAMERAS)] = CAMERAS[0]
    start: Annotated[float | None, domains.TIME] = None
    stop: Annotated[float | None, domains.TIME] = None
    slow_motion: Annotated[float, domains.SLOW_MOTION] = 1.0
    fps: Annotated[int, domains.FPS] = 30
    hide: Annotated[tuple[str, ...], Choice("NAMES")] = ()
    flags: Annotated[tuple[str, ...], Choice("NAME"), "flag"] = ()

    def __post_init__(self) -> None:
        """Refuse a video that ends before it begins, and names that nothing in it has.

        Raises:
            click.UsageError: The video ends before it begins.
            InputError: A name is unknown.
        """
        if self.hide or self.flags:
            look(self.hide, self.flags)
        if self.start is not None and self.stop is not None and self.start > self.stop:
            raise click.UsageError(f"--start {self.start:g} comes after --stop {self.stop:g}; swap them.")

    def render(self, walk: mjbiped.Walk, path: Path, *, progress: bool) -> None:
        """Draw the video of a walk."""
        from mjbiped.rendering.video import render_video

        settings = dict(vars(self))
        width, height = map(int, settings.pop("video_size").split("x"))
        render_video(walk, path, width=width, height=height, progress=progress, **settings)


@dataclass
class Study:
    """How the walks of a study are made.

    Walks:
        workers: Number of processes; one for each core unless given.
        scheduler: Run on the workers of this Dask scheduler, such as tcp://host:8786; needs pip install
            'mjbiped[cluster]'.
        fresh: Delete the rows of an earlier run and begin again.
    """

    workers: Annotated[int | None, domains.WORKERS] = None
    scheduler: Annotated[str | None, Choice("ADDRESS")] = None
    fresh: bool = False

    def __post_init__(self) -> None:
        """Refuse a number of local processes together with a scheduler, which has workers of its own.

        Raises:
            click.UsageError: Both are given.
        """
        if self.workers is not None and self.scheduler is not None:
            raise click.UsageError("--workers is for this machine; the workers of a --scheduler are its own.")
