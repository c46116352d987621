"""A robot on its ground as one MJCF file, which opens in plain MuJoCo."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from string import Template
from xml.etree import ElementTree

import numpy as np

from mjbiped.control.controller import Unpowered
from mjbiped.control.registry import SHARED
from mjbiped.engines.mujoco.engine import Mujoco
from mjbiped.engines.mujoco.ground import Ground
from mjbiped.engines.mujoco.scene import START_DEPTH, first_state, scene_spec
from mjbiped.engines.mujoco.scenery import add_section
from mjbiped.engines.mujoco.setup import ground_needed
from mjbiped.engines.mujoco.surface import add_surface
from mjbiped.engines.plan import DEFAULT_STEPS, Plan, Terms, make_plan
from mjbiped.errors import GaitError, InputError
from mjbiped.exchange.ros import joined
from mjbiped.gaits.described import passive_gait_of, usual_gait
from mjbiped.gaits.gait import Gait
from mjbiped.robots.in_space import InSpace
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.files import saved
from mjbiped.utils.mujoco import mujoco
from mjbiped.version import __version__

TIMESTEP = 1e-4
"""Length of all physics steps, s: plain steps as long as this resolve impacts (docs/physics.md)."""

START = "start"
"""Name of the keyframe with the start posture."""

MOST_BUILT = 10_000
"""Greatest number of segments in a scene. A scene of this size is written in 7 s and opened by MuJoCo in 2 s; one of
twice the size takes 27 s and 7 s, for MuJoCo makes its lists of geoms anew for each added geom."""

_BROAD = 4.0  # half width of ground that falls to one side, leg lengths
_STANCE, _OTHERS = 1, 2  # bits of contype and conaffinity: of the first stance foot, and of the other feet


def export_scene(robot: Robot, terrain: Terrain, path: str | Path, *, initial: str | Sequence[float] = "gait") -> None:
    """Write a robot on its ground as one MJCF file, without controller, for plain MuJoCo.

    A comment in the file says what mjbiped's engine does that the file cannot. Its keyframe "start" is the first state.

    Args:
        robot: The robot.
        terrain: The ground.
        path: File to write, `.xml`.
        initial: The first state: "rest"; the robot's angles and rates; or "gait": the start of the passive gait on the
            slope under x = 0, or, if there is no such gait, of the gait that controllers imitate.

    Raises:
        InputError: The ground has more than `MOST_BUILT` segments or is a surface, the first state is refused as
            `mjbiped.walk` refuses it, or legs are too short or too long for MuJoCo.
        GaitError: The robot has no gait: give another first state.
        RecordError: The file cannot be written.
    """
    if len(terrain.x) > MOST_BUILT:
        raise InputError(
            f"the ground has {len(terrain.x)} segments; expected at most {MOST_BUILT}, as MuJoCo takes very long to "
            "open a scene of more: give a shorter ground"
        )
    if terrain.surface is not None:
        raise InputError(
            f"a scene holds profiles, and the ground {terrain.caption} is a surface; give ground of segments, or "
            "render a walk on it"
        )
    if initial == "gait":
        initial = _gait_of(robot, terrain.slope_at(0.0)).start.tolist()
    terms = Terms(Mujoco(), None, None, robot, None, ScuffingRule())
    root = _scene_of(make_plan(terms, Unpowered(), terrain, initial))  # checked as for a walk without torques
    root.insert(0, ElementTree.Comment(notes_of(robot, terrain, TIMESTEP)))
    with saved(Path(path)) as unfinished:
        ElementTree.ElementTree(root).write(unfinished, encoding="utf-8")


def _gait_of(robot: Robot, slope: float) -> Gait:
    """Return the passive gait on a slope (rad); where there is none, the gait that controllers imitate."""
    with suppress(GaitError):
        return passive_gait_of(robot, slope)
    try:
        return usual_gait(robot, math.radians(SHARED["imitate_slope_deg"]))
    except GaitError as error:
        raise GaitError(f'{error}; or begin at rest: initial="rest" (--initial rest)') from error


def _scene_of(plan: Plan) -> ElementTree.Element:
    """The scene with the first state of a walk."""
    robot = plan.robot
    reach = plan.terms.scuffing.reach * robot.leg_length
    terrain, cut = _parted(plan.terrain, -reach if robot.collides_from_lift_off else reach)
    reach, broad = ground_needed(robot, DEFAULT_STEPS, None), None if terrain.is_profile else _BROAD * robot.leg_length
    ground = Ground(terrain, reach=reach, cut=cut, half_width=broad)
    spec = scene_spec(robot, ground, ground.pieces, timestep=TIMESTEP)
    if isinstance(robot, InSpace):
        add_surface(spec, ground, ground.pieces, robot.leg_length, 0.0)
    else:
        add_section(spec, ground, ground.pieces, robot.leg_length)
    spec.modelname = f"mjbiped {robot.kind}"
    for sensor in [each for each in spec.sensors if each.type == mujoco.mjtSensor.mjSENS_USER]:
        spec.delete(sensor)  # MuJoCo would call callbacks for them, which only mjbiped installs
    _let_others_pass(spec, robot, ground, cut)
    # the file opens with the robot upright on the ground
    height = robot.posture((0.0, terrain.height_at(0.0)), 0, [0.0] * len(robot.angles))[1]
    spec.body("hip").pos = [0.0, 0.0, height]
    spec.joint("hip_z").ref = height
    model = spec.compile()
    key = spec.add_key(name=START)
    key.qpos, key.qvel = [0.0] * model.nq, [0.0] * model.nv
    for name, place, rate in zip(robot.places, *_start_of(robot, terrain, plan), strict=True):
        address = int(model.joint(name).qposadr[0])
        key.qpos[address], key.qvel[address] = place, rate
    return exact_xml(spec, spec.compile())


def _start_of(robot: Robot, terrain: Terrain, plan: Plan) -> tuple[Iterable[float], Iterable[float]]:
    """Posture and rates at the start of a walk, in the order of `robot.places`."""
    if not isinstance(robot, InSpace):
        return first_state(robot, terrain, plan.q, plan.dq)
    y = 0.5 * robot.hip_width
    place = np.array([0.0, y, terrain.height_at(0.0, y) - START_DEPTH])
    posture, rates = robot.started(place, terrain.normal_at(0.0, y), np.array(plan.q), np.array(plan.dq))
    return posture.tolist(), rates.tolist()


def _parted(terrain: Terrain, x: float) -> tuple[Terrain, int]:
    """Let a segment that is not the first begin at x (m), and return its index.

    Raises:
        InputError: The terrain ends before x.
    """
    if x >= terrain.end:
        raise InputError(
            f"the ground ends at x = {terrain.end:g} m; expected more than {x:g} m, a place for a first step"
        )
    aside = terrain.lateral or (0.0,) * len(terrain.x)
    rows, index = list(zip(terrain.x, terrain.z, terrain.angle, aside, strict=True)), terrain.segment_at(x)
    begun = x, terrain.height_at(x), terrain.slope_at(x), aside[index]
    if x <= terrain.x[0]:  # the first segment extends backwards
        rows[:1] = [(x - 1.0, terrain.height_at(x - 1.0), *begun[2:]), begun]
        index = 1
    elif terrain.x[index] != x:
        index += 1
        rows.insert(index, begun)
    starts, heights, angles, aside = zip(*rows, strict=True)
    return replace(terrain, x=starts, z=heights, angle=angles, lateral=aside), index


def _let_others_pass(spec: mujoco.MjSpec, robot: Robot, ground: Ground, cut: int) -> None:
    """Let all feet but the stance foot pass through the ground before the segment `cut`."""
    ahead = {piece.name for piece in ground.pieces if piece.segments.start >= cut}
    ahead |= {f"riser_{index}" for index in range(cut, len(ground.starts))}
    for name in ahead:  # `spec.geoms` would take a time that grows with the square of their number
        if (geom := spec.geom(name)) is not None:  # not each edge has a riser
            geom.conaffinity = _STANCE | _OTHERS
    for name in (name for limb in robot.bodies.limbs[1:] for name in robot.bodies.feet(limb)):
        spec.geom(name).contype = _OTHERS


_ATTRIBUTES = {
    "body": {"pos": "pos", "quat": "quat"},
    "inertial": {"pos": "ipos", "mass": "mass", "diaginertia": "inertia"},
    "geom": {"pos": "pos", "quat": "quat", "size": "size", "friction": "friction", "solref": "solref"},
    "joint": {"pos": "pos", "ref": "qpos0", "range": "range"},
    "hfield": {"size": "size", "elevation": "data"},
    "key": {"qpos": "qpos", "qvel": "qvel"},
}
"""Attributes of elements whose numbers are written exactly, with their names in the compiled model."""

_close = partial(math.isclose, rel_tol=1e-5, abs_tol=1e-12)  # whether a number equals another one rounded to six digits


def exact_xml(spec: mujoco.MjSpec, model: mujoco.MjModel) -> ElementTree.Element:
    """Write a model as XML, with exact numbers for bodies, joints, geoms and keyframes.

    Args:
        spec: The specification; elements without a name keep rounded numbers.
        model: The compiled specification.
    """
    root = ElementTree.fromstring(spec.to_xml())
    for element in (each for section in ("asset", "worldbody", "keyframe") for each in root.findall(f"{section}//*")):
        name = element.get("name")
        if element.tag in _ATTRIBUTES and name is not None:
            for part in (element, *element.findall("inertial")):
                _write(part, getattr(model, element.tag)(name))
    option = root.find("option")
    assert option is not None  # its timestep is not MuJoCo's own
    option.set("timestep", repr(float(model.opt.timestep)))
    option.set("gravity", joined(model.opt.gravity))
    return root


def _write(element: ElementTree.Element, compiled: object) -> None:
    """Replace numbers of an element that are rounded to six digits by those of the compiled model."""
    for name, field in _ATTRIBUTES[element.tag].items():
        rounded = [float(number) for number in element.get(name, "").split()]
        exact = np.ravel(getattr(compiled, field))[: len(rounded)].tolist()
        # NumPy's `allclose` would take half of the time of an export
        if rounded and len(exact) == len(rounded) and all(map(_close, exact, rounded)):
            element.set(name, joined(exact))


_WIDTH = 110  # characters of a line


def notes_of(robot: Robot, terrain: Terrain, timestep: float) -> str:
    """Describe an exported scene.

    Args:
        robot: The robot.
        terrain: The ground.
        timestep: Length of the file's steps, s.
    """
    (behind, ahead), reach = robot.sole or (0.0, 0.0), ScuffingRule().reach * robot.leg_length
    numbers = {"timestep": timestep, "behind": behind, "ahead": ahead, "reach": reach}
    words = {"kind": robot.kind, "terrain": terrain.caption, "version": __version__}
    words |= {name: f"{number:g}" for name, number in numbers.items()}
    left_out = {
        "scuffing" if robot.collides_from_lift_off else "lift_off",
        "" if "knee" in robot.joints else "knees",
        "" if robot.sole is not None else "sole",
    }
    text = Path(__file__).with_name("notes.txt").read_text(encoding="utf-8")
    notes = dict(line.split(": ", 1) for line in text.splitlines())
    lines = [Template(note).substitute(words) for name, note in notes.items() if name not in left_out]
    lines = ["".join(letter for letter in line if letter.isprintable()) for line in lines]  # XML allows no others
    told = "\n".join(textwrap.fill(line, _WIDTH, initial_indent="    ", subsequent_indent="    ") for line in lines)
    return f"\n{told.replace('--', '- -')}\n  "  # an XML comment must not contain two hyphens
