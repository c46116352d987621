"""What the command line's options are made of: types that check their values, and help in sections."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any, TypeVar

import click

from controllers import AdaptiveController
from controllers.comparison.known_slope import SLOPE_SOURCES
from mjbiped.control.fields import shown_defaults
from mjbiped.control.own import FORMS, is_reference
from mjbiped.control.registry import DEFAULT_CONTROLLER, SHARED, controller_names, settings_of
from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.engines.mujoco.options import DEFAULT_CONTACT_TIMESTEP, DEFAULT_TIMESTEP
from mjbiped.engines.names import DEFAULT_ENGINE, ENGINES
from mjbiped.engines.plan import DEFAULT_STEPS, INITIAL_STATES
from mjbiped.errors import InputError, shown
from mjbiped.gaits.optimised import parse_reference
from mjbiped.plotting.width import DEFAULT_WIDTH, WIDTHS, figure_width
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.files import parse_number
from mjbiped.utils import domains
from mjbiped.utils.domains import Count, Domain
from mjbiped.utils.files import check_writable

_Function = TypeVar("_Function", bound=Callable[..., Any])

Row = tuple[str, Any, Any, str]
"""An option: its names, type (numbers: their domain), default, and help."""


class Kind(click.types.FuncParamType):  # type: ignore[type-arg]  # generic in the latest click alone
    """Values that a function reads; `metavar` stands for one in the help."""

    def __init__(self, metavar: str, read: Callable[[Any], Any]) -> None:
        """Take the name beside the function."""
        super().__init__(read)
        self.metavar = metavar


class Folder(click.Path):
    """The path of a folder, which need not be there."""

    metavar = "FOLDER"

    def __init__(self) -> None:
        """Take folders alone."""
        super().__init__(file_okay=False, path_type=Path)


class SectionOption(click.Option):
    """An option that stands in a section of its command's help."""

    def __init__(self, *args: Any, section: str = "Options", **kwargs: Any) -> None:
        """Take the section beside an option's usual arguments."""
        super().__init__(*args, **kwargs)
        self.section = section


class SectionCommand(click.Command):
    """A command whose help lists its options by section, in the order in which the sections first occur."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options into the help, one list per section."""
        sections: dict[str, list[tuple[str, str]]] = {}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is not None and isinstance(parameter, click.Option):
                sections.setdefault(getattr(parameter, "section", "Options"), []).append(record)
        sections["Options"] = sections.pop("Options", [])  # --help and its like come last
        for section, records in sections.items():
            with formatter.section(section):
                formatter.write_dl(records)


def options(section: str, *rows: Row) -> Callable[[_Function], _Function]:
    """Options of one section of the help: a decorator for the command's function."""

    def decorate(function: _Function) -> _Function:
        for name, given, default, text in reversed(rows):
            kind = quantity(given) if isinstance(given, Domain | Count) else given
            function = click.option(
                *name.split(),
                cls=SectionOption,
                section=section,
                type=kind,
                is_flag=kind is bool,
                default=default,
                multiple=default == (),
                show_default=default is not None and default is not False and default != (),
                metavar=getattr(kind, "metavar", None),
                help=text,
            )(function)
        return function

    return decorate


def output(*suffixes: str) -> Kind:
    """The type of a file to write: its suffix is one of these, its folder is there and takes new files.

    A file that is there already may be replaced.
    """

    def convert(value: Any) -> Path:
        path = Path(value)
        if path.suffix not in suffixes:
            raise click.BadParameter(f"{shown(str(path))} must end in {' or '.join(suffixes)}.")
        try:
            if path.is_dir():
                raise click.BadParameter(f"{shown(str(path))} is a folder.")
            if not path.parent.is_dir():
                raise click.BadParameter(
                    f"{shown(str(path))}: there is no folder {shown(str(path.parent))}; make it first."
                )
            check_writable(path)
        except (OSError, ValueError) as error:  # a name that no file can have is a ValueError
            reason = getattr(error, "strerror", None) or error
            raise click.BadParameter(f"{shown(str(path))} cannot be written: {reason}.") from error
        return path

    return Kind("FILE", convert)


def quantity(domain: Domain | Count) -> Kind:
    """The type of a number of a domain."""

    def number(value: Any) -> float:
        try:
            return domain.check("", parse_number(value) if isinstance(value, str) else value)
        except InputError as error:
            raise click.BadParameter(f"{shown(value)}; expected {domain.words}.") from error

    return Kind("X" if isinstance(domain, Domain) else "N", number)


def span(domain: Domain) -> Kind:
    """The type of two numbers of a domain as "0.8..1.6", the first below the second."""

    def ends(value: Any) -> tuple[float, float]:
        first, _, second = str(value).partition("..")
        try:
            low, high = (domain.check("", parse_number(end)) for end in (first, second))
        except InputError:
            low = high = math.nan
        if not low < high:
            raise click.BadParameter(
                f"{shown(value)}; expected two numbers LOW..HIGH, {domain}, the first below the second, as 0.8..1.6."
            )
        return low, high

    return Kind("LOW..HIGH", ends)


def delay(value: Any) -> float | None:
    """A number, or "none"."""
    if isinstance(value, str) and value.strip().lower() == "none":
        return None
    try:
        number: float = quantity(domains.REPLANNING_DELAY)(value)
        return number
    except click.BadParameter as error:
        raise click.BadParameter(f"{error.message[:-1]}, or 'none' to switch re-planning off.") from error


def initial_state(value: str) -> str | tuple[float, ...]:
    """The name of a walk's first state, or four numbers, or six of a robot with knees."""
    if value in INITIAL_STATES:
        return value
    try:
        numbers = [parse_number(part) for part in value.split(",")]
        return tuple(domains.check_states("", numbers, (6 if len(numbers) == 6 else 4,)).tolist())
    except InputError as error:
        wanted = f"{', '.join(map(repr, INITIAL_STATES))} or four numbers q1,q2,dq1,dq2 (rad, rad/s)"
        raise click.BadParameter(f"{shown(value)}; expected {wanted}.") from error


def gain(value: str) -> tuple[str, str]:
    """A setting's name and value, as "ratio=-2"; the controller knows which it has, their types and domains."""
    name, _, rest = value.partition("=")
    if not name.strip() or not rest.strip():
        raise click.BadParameter(f"{shown(value)}; expected NAME=VALUE, as gain=10.")
    return name.strip(), rest


def push(value: str) -> tuple[float, float]:
    """When a push begins (s) and its impulse (N s), as "2:-5"."""
    time, _, impulse = value.partition(":")
    try:
        return domains.TIME.check("", parse_number(time)), domains.PUSH.check("", parse_number(impulse))
    except InputError as error:
        raise click.BadParameter(f"{shown(value)}; expected TIME:IMPULSE in s and N s, as 2:-5.") from error


def model_error(value: str) -> tuple[str, float]:
    """A parameter of the robot and a factor, as "leg_mass=1.2"."""
    name, _, factor = value.partition("=")
    try:
        known = list(dict.fromkeys(field.name for kind in (Compass, KneedBiped) for field in fields(kind)))
        domains.known_name("parameter of the robot", name.strip(), known)
        return name.strip(), domains.MODEL_ERROR.check("", parse_number(factor))
    except InputError as error:
        names = ", ".join(known)
        raise click.BadParameter(
            f"{shown(value)}; expected NAME=FACTOR, as leg_mass=1.2, of {names}, and {domains.MODEL_ERROR.words}."
        ) from error


def controller_name(value: str) -> str:
    """The name of a registered controller, or of a class of the user's own, which is not loaded yet."""
    if is_reference(value) or value in controller_names():
        return value
    names = controller_names()
    hint = domains.nearest(value, names) or "."
    raise click.BadParameter(f"{shown(value)}; expected one of {', '.join(names)}, or {FORMS}{hint}")


CONTROLLER = Kind("NAME", controller_name)


def reference(value: Any) -> str:
    """What is asked of an optimised reference, as it was written."""
    try:
        parse_reference(value)
    except InputError as error:
        raise click.BadParameter(f"{error}.") from error
    return str(value)


PLOT = output(".png", ".pdf", ".svg")
_LAW = AdaptiveController  # for its defaults
COMPARED = ("passivity", "energy-constraint", "kinetic-energy", "limit-cycle")  # in the paper
OTHERS = (*COMPARED, *(name for name in controller_names() if name not in ("adaptive", "passive", *COMPARED)))


def gains_of(name: str, robot: Robot | None = None) -> dict[str, Any]:
    """Names of the settings that `--gain` sets, with their defaults; those left out have options of their own."""
    return {key: value for key, value in settings_of(name, robot).items() if key not in (*SHARED, "slope_source")}


ADAPTIVE, COMPARISON, MUJOCO = "Adaptive controller", "Comparison controllers", "MuJoCo"

walk_options = options(
    "Walk",
    ("--seed", domains.SEED, None, "Seed of random ground."),
    ("--steps", domains.STEPS, None, f"End after so many steps; {DEFAULT_STEPS} without a distance."),
    ("--distance", domains.DISTANCE, None, "End at this position x of the stance foot, m."),
    (
        "--initial",
        Kind("STATE", initial_state),
        "gait",
        "First state: 'gait' (on the limit cycle), 'rest' (legs together, at rest), or q1,q2,dq1,dq2 of stance and "
        "swing leg from the ground's normal, rad and rad/s; with knees q1,q2,q3,dq1,dq2,dq3.",
    ),
    (
        "--controller",
        CONTROLLER,
        DEFAULT_CONTROLLER,
        "'adaptive' imitates a passive gait on ground of unknown slope; 'passive' applies no torque; "
        f"{', '.join(COMPARED)} are those that the paper compares with, see docs/comparison.md. Your own by its class: "
        f"{FORMS}, as spread.py:HipSpread.",
    ),
)


def gain_option(section: str) -> Callable[[_Function], _Function]:
    """The option that sets a controller's fields."""
    known = "; ".join(f"{name}: {shown_defaults(gains_of(name))}" for name in COMPARED)
    text = f"Sets a field of the controller, may be repeated; {known}; your own: those of its dataclass."
    return options(section, ("--gain", Kind("NAME=VALUE", gain), (), text))


mujoco_options = options(
    MUJOCO,
    ("--timestep", domains.TIMESTEP, DEFAULT_TIMESTEP, "Longest physics step, s."),
    ("--contact-timestep", domains.CONTACT_TIMESTEP, DEFAULT_CONTACT_TIMESTEP, "Physics step that makes an impact, s."),
    (
        "--control-period",
        domains.CONTROL_PERIOD,
        None,
        "Time between ticks of the controller, s; each physics step unless given.",
    ),
    (
        "--plain-steps",
        bool,
        False,
        "Steps of the one length --timestep (0.1 ms or less): none ends at a touchdown, and contacts alone tell of it.",
    ),
)


def scuffing_option(section: str) -> Callable[[_Function], _Function]:
    """The option for the scuffing rule: which scuffs are passed through, and which steps are long enough."""
    text = "Leg lengths ahead of the stance foot from which the swing foot may touch the ground; steps must be longer."
    return options(section, ("--scuffing-reach", domains.REACH, ScuffingRule.reach, text))


engine_option = options(
    "Walk",
    (
        "--engine",
        click.Choice(tuple(ENGINES)),
        DEFAULT_ENGINE,
        "The physics: MuJoCo's contacts, or the paper's impact map.",
    ),
)

REFERENCE: Row = (
    "--reference",
    Kind("GOAL", reference),
    SHARED["reference"],
    "Track an optimised gait instead: clearance=X,retraction=no,speed=X,torque_limit=X,friction=X, any of them, in m, "
    "m/s and N m; for adaptive and limit-cycle.",
)

adaptive_options = options(
    ADAPTIVE,
    (
        "--imitate-slope-deg",
        domains.SLOPE_DEG,
        SHARED["imitate_slope_deg"],
        "Slope of the passive gait that is imitated; for all but passive.",
    ),
    REFERENCE,
    ("--position-gain", domains.GAIN, _LAW.position_gain, "K1, 1/s."),
    ("--velocity-gain", domains.GAIN, _LAW.velocity_gain, "K2, 1/s."),
    ("--adaptation-gain", domains.ADAPTATION_GAIN, _LAW.adaptation_gain, "gamma of the slope estimator."),
    (
        "--replanning-delay",
        Kind("ZETA", delay),
        _LAW.replanning_delay,
        "Gait periods, in (0, 1], in which re-planning leads back to the gait; 'none' switches it off.",
    ),
    ("--estimate-update/--no-estimate-update", bool, _LAW.estimate_update, "Correct the slope estimate at touchdown."),
    (
        "--initial-slope-estimate-deg",
        domains.SLOPE_DEG,
        SHARED["initial_slope_estimate_deg"],
        "Slope estimate at the start; for the comparison controllers the slope that they are given.",
    ),
)

comparison_options = options(
    COMPARISON,
    (
        "--slope-source",
        click.Choice(SLOPE_SOURCES),
        None,
        "The slope that gravity is compensated for: as given at the start, dead reckoned under the stance foot, or of "
        "the line through both feet; two_point for passivity, local for the others unless given.",
    ),
)

KNEED = {"kneed": KneedBiped, "halved-rods": KneedBiped.halved_rods}
"""Robots with knees, by their names on the command line."""


def robot_name(value: Any) -> str:
    """A robot's name, or the path of a file that has one."""
    text = str(value)
    if text not in (Compass.kind, *KNEED) and not text.endswith(".toml"):
        raise click.BadParameter(f"{shown(text)}; expected {', '.join((Compass.kind, *KNEED))}, or a .toml file.")
    return text


KIND: Row = (
    "--robot",
    Kind("NAME|FILE", robot_name),
    Compass.kind,
    "'compass' has straight legs; 'kneed' has knees, light shanks and a heavy hip; 'halved-rods' has the legs of Table "
    'I cut at the knee; or a .toml file with kind = "kneed" (or "compass") and parameters as in the record. The '
    "options below change single parameters.",
)
"""Which robot, for `options`."""

LEGS, KNEES = "Robot", "Robot with knees"
"""Sections of a robot's options."""

knee_options = options(
    KNEES,
    ("--thigh-mass", domains.LEG_MASS, None, "Mass of one thigh, kg."),
    ("--shank-mass", domains.LEG_MASS, None, "Mass of one shank, kg."),
    ("--thigh-length", domains.LENGTH, None, "From the hip to the knee, m."),
    ("--shank-length", domains.LENGTH, None, "From the knee to the foot, m."),
    ("--thigh-centre", domains.LENGTH, None, "From the hip down to the thigh's centre of mass, m."),
    ("--shank-centre", domains.LENGTH, None, "From the knee down to the shank's centre of mass, m."),
    ("--thigh-inertia", domains.INERTIA, None, "Of a thigh about its centre of mass, kg m^2; a rod's unless given."),
    ("--shank-inertia", domains.INERTIA, None, "Of a shank, the same."),
)

leg_options = options(
    LEGS,
    ("--leg-mass", domains.LEG_MASS, Compass.leg_mass, "Mass of one leg, kg."),
    ("--hip-mass", domains.HIP_MASS, Compass.hip_mass, "Mass at the hip, kg."),
    ("--lower-length", domains.LENGTH, Compass.lower_length, "From the foot to the leg's centre of mass, m."),
    ("--upper-length", domains.LENGTH, Compass.upper_length, "From the leg's centre of mass to the hip, m."),
    (
        "--leg-inertia",
        domains.INERTIA,
        None,
        "Inertia of a leg about its centre of mass, kg m^2; a uniform rod's unless given.",
    ),
    ("--gravity", domains.GRAVITY, Compass.gravity, "Acceleration of gravity, m/s^2."),
)


def robot_options(function: _Function) -> _Function:
    """Which robot, and its parameters."""
    return options(LEGS, KIND)(leg_options(knee_options(function)))


records_option = options(
    "Results",
    ("--out", output(".npz"), None, "Write both records: a.npz gives a_mujoco.npz and a_hybrid.npz."),
)
_DISTURBANCES = ", ".join(
    f"{field.name}={'none' if field.default is None else f'{field.default:g}'}"
    for field in fields(Disturbances)
    if field.name != "pushes"
)

disturbance_options = options(
    "Disturbances",
    (
        "--disturb",
        Kind("NAME=VALUE", gain),
        (),
        f"Noise, delay, weak motors, random pushes, in SI units; may be repeated: {_DISTURBANCES}. "
        "docs/disturbances.md explains them.",
    ),
    (
        "--push pushes",
        Kind("TIME:IMPULSE", push),
        (),
        "Push the hip forward from this time on, s, by so many N s (backward: negative); may be repeated.",
    ),
    (
        "--model-error",
        Kind("NAME=FACTOR", model_error),
        (),
        "The controller takes the robot's NAME, as leg_mass, for FACTOR times what it is; may be repeated.",
    ),
)

record_option = options("Results", ("--out", output(".npz"), None, "Write the record, an .npz file."))


def width_option(function: _Function) -> _Function:
    """How wide figures are: it holds for all that the command draws, and the command itself takes no notice."""
    sizes = ", ".join(f"{name} {size.inches:g} in" for name, size in WIDTHS.items())
    return click.option(
        "--plot-width",
        cls=SectionOption,
        section="Results",
        type=click.Choice(tuple(WIDTHS)),
        default=DEFAULT_WIDTH,
        show_default=True,
        expose_value=False,
        callback=lambda ctx, _, name: ctx.with_resource(figure_width(name)),
        help=f"Width of figures: {sizes}; page is for the screen, double and single are columns in print.",
    )(function)


def plot_option(function: _Function) -> _Function:
    """A figure, and how wide it is."""
    return options("Results", ("--plot", PLOT, None, "Write a figure, .png, .pdf or .svg."))(width_option(function))


json_option = options("Results", ("--json", bool, False, "Print the results as JSON instead of a table."))
quiet_option = options("Results", ("--quiet", bool, False, "Print errors only, and JSON if asked for."))


def walker_options(function: _Function) -> _Function:
    """All options that say who walks where and how, but for the engine."""
    parts = (
        walk_options,
        gain_option("Walk"),
        scuffing_option("Walk"),
        mujoco_options,
        adaptive_options,
        comparison_options,
        robot_options,
        disturbance_options,
    )
    for part in reversed(parts):
        function = part(function)
    return function


def printed_options(function: _Function) -> _Function:
    """What a command prints."""
    return json_option(quiet_option(function))
