"""Robot MJCF and terrain to one `mujoco.MjModel`.

The robot (`models/compass.xml`) and its surroundings (`models/scene.xml`) stand in files; this module writes the
robot's parameters over them and puts the terrain in the floor's place, with `mujoco.MjSpec`:

* an endless terrain of a single slope becomes a **plane**;
* a stretch between two steps becomes a **box** where it is level, and a **heightfield** where it is not: a tilted box
  has leaning ends, and a step beside it would stand before or behind its place;
* a step gets a thin frictionless **riser** before its face, bevelled at the top so that no foot can stand on it;
* every slope change and step edge gets a stripe that only the eye meets.

Feet are spheres of radius `FOOT_RADIUS` about the legs' ends, and all ground lies lower by that radius along its
normal, so that a leg's end touches the profile exactly when the contact's distance is zero.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import resources
from itertools import pairwise
from pathlib import Path

import mujoco
import numpy as np

from mjbiped.compass import Compass
from mjbiped.errors import InputError
from mjbiped.landing import stiffness
from mjbiped.scenery import add_earth
from mjbiped.terrain import GROUND_FRICTION, Terrain

FOOT_RADIUS = 1e-4
"""Radius of the colliding foot sphere, m: the step length's error is 0.009 % at 1e-4, 0.13 % at 1e-3, 1.2 % at 1e-2."""

SMALLEST_HIP_MASS = 1e-5
"""MuJoCo's compiler refuses a moving body without mass; this part of the robot's mass is invisible in every figure."""

SMALLEST_INERTIA = 2e-10
"""The same for a leg without inertia about its centre of mass, in leg mass times leg length squared."""

RECORDS = "walks"
"""The model's one numeric field, of so many numbers: for `mjbiped.native`, which says what stands there."""
RECORDS_SIZE = 4

GROUND_KINDS = ("auto", "heightfield", "boxes")

_THICKNESS = 0.12  # of boxes and heightfield bases, m; contacts are never deeper than some 0.1 mm
_HALF_WIDTH = 0.6  # of the ground across the walking direction, m
_RISER_PROUD = 3e-4  # a riser stands before the tread's own frictional end face, m
_RISER_BACK = 1.5e-3  # how far it reaches back into the step; below a tread of up to 28 degrees, m
_BEVEL = 2.0  # rise over run of a riser's upper edge: its normal then faces up by 0.45, a face and no foothold
_LIP = 1e-4  # of the tread's own end left above the bevel, m: a foot at the tread's edge stands on the tread alone
_BACKWARD = 3.0  # ground behind the start, m: more than a fallen robot reaches


@dataclass(frozen=True)
class Scene:
    """A compiled scene.

    Attributes:
        model: The MuJoCo model; its `userdata` has the size asked for.
        start: Where the ground begins, x in m.
        end: Where the ground ends, x in m: the terrain's own end, or as far as was built.
        proud: How far at most a riser's plate stands before its face, m.
    """

    model: mujoco.MjModel
    start: float
    end: float
    proud: float


def build_scene(
    robot: Compass,
    terrain: Terrain,
    *,
    timestep: float,
    reach: float,
    ground: str = "auto",
    userdata: int = 0,
    scenery: bool = False,
) -> Scene:
    """Build the MuJoCo model of a robot on a terrain.

    Args:
        robot: The robot's parameters.
        terrain: The ground's profile.
        timestep: Of the steps that the contacts are made for, s. Their damping is 1 / timestep: with it an impact is
            plastic within one step.
        reach: How far ahead of x = 0 the last segment must reach, m; a terrain that ends earlier keeps its end.
        ground: "auto" (see the module), or "heightfield" or "boxes" for all stretches alike.
        userdata: Number of floats in `mjData.userdata`.
        scenery: Add the earth under the ground, for pictures.

    Returns:
        The scene.

    Raises:
        InputError: `ground` is unknown, or the terrain's end lies behind the start.
    """
    if ground not in GROUND_KINDS:
        raise InputError(f"unknown ground {ground!r}; valid are {', '.join(GROUND_KINDS)}")
    spec = mujoco.MjSpec.from_file(str(models_folder() / "scene.xml"))
    spec.nuserdata = userdata
    spec.add_numeric(name=RECORDS, size=RECORDS_SIZE, data=[0.0] * RECORDS_SIZE)
    _set_robot(spec, robot, timestep)
    end = min(terrain.end, max(reach, terrain.x[-1] + 1.0))
    _replace_floor(spec, terrain, end, ground)
    if scenery:
        profile = [point for start, stop, _ in _corners(terrain, end) for point in (start, stop)]
        add_earth(spec, profile, _HALF_WIDTH)
    for key in list(spec.keys):
        spec.delete(key)  # they hold Table I's postures on a 2 degree slope
    leans = [_lean(terrain, index) for index in range(len(terrain.x))] if ground == "boxes" else [0.0]
    return Scene(spec.compile(), start=terrain.x[0] - _BACKWARD, end=end, proud=_RISER_PROUD + max(leans))


def models_folder() -> Path:
    """Folder of the MJCF files, in a checkout as in an installed wheel."""
    package = Path(str(resources.files("mjbiped")))
    installed = package / "models"
    return installed if installed.is_dir() else package.parent / "models"


def _set_robot(spec: mujoco.MjSpec, robot: Compass, timestep: float) -> None:
    """Write the robot's parameters, the timestep and the damping that belongs to it over the spec."""
    spec.option.timestep = timestep
    spec.option.gravity = [0.0, 0.0, -robot.gravity]
    length = robot.leg_length
    spec.body("hip").mass = max(robot.hip_mass, SMALLEST_HIP_MASS * robot.total_mass)
    solref = [-stiffness(timestep), -1.0 / timestep]
    for side, y in (("left", 0.04), ("right", -0.04)):
        leg = spec.body(f"{side}_leg")
        leg.mass = robot.leg_mass
        leg.ipos = [0.0, 0.0, -robot.upper_length]
        leg.inertia = [max(robot.leg_inertia, SMALLEST_INERTIA * robot.leg_mass * length**2)] * 3
        foot = spec.geom(f"{side}_foot")
        foot.pos = [0.0, 0.0, -length]
        foot.size = [FOOT_RADIUS, 0.0, 0.0]
        foot.friction = [GROUND_FRICTION, 0.0, 0.0]
        foot.solref[:2] = solref
        spec.geom(f"{side}_shank").fromto = [0.0, y, 0.0, 0.0, y, -length + 0.018]
        spec.geom(f"{side}_tip").pos = [0.0, y, -length + 0.024]
        spec.geom(f"{side}_mass").pos = [0.0, y, -robot.upper_length]
    riser = spec.find_default("riser").geom
    riser.solref[:2] = solref


def _replace_floor(spec: mujoco.MjSpec, terrain: Terrain, end: float, ground: str) -> None:
    """Put the terrain in the place of the scene file's floor."""
    spec.delete(spec.geom("floor"))
    corners = _corners(terrain, end)
    if len(corners) == 1 and ground == "auto" and math.isinf(terrain.end):
        _add_plane(spec, terrain)
        return
    for number, stretch in enumerate(_by_stretch(terrain, corners)):
        level = all(slope == 0.0 for _, _, slope in stretch)
        if ground == "heightfield" or (ground == "auto" and not level):
            _add_heightfields(spec, f"ground_{number}", [(start, stop) for start, stop, _ in stretch])
        else:
            for index, (start, stop, slope) in enumerate(stretch):
                _add_box(spec, f"ground_{number}_{index}", start, stop, slope)
    for index, rise in enumerate(terrain.rises):
        x = terrain.x[index]
        if index and x < end:
            _add_edge(spec, f"edge_{index}", x, terrain.z[index], rise)
            if rise != 0.0:
                _add_riser(spec, f"riser_{index}", terrain, index, leaning=ground == "boxes")


Corner = tuple[tuple[float, float], tuple[float, float], float]


def _corners(terrain: Terrain, end: float) -> list[Corner]:
    """Each segment that is built, as its first point, last point and slope; the first reaches back, the last to end."""
    stops = [*terrain.x[1:], end]
    corners: list[Corner] = []
    for index, (x, z, slope) in enumerate(zip(terrain.x, terrain.z, terrain.angle, strict=True)):
        start, stop = (x - _BACKWARD if index == 0 else x), min(stops[index], end)
        if stop > start:
            fall = math.tan(slope)
            corners.append(((start, z - fall * (start - x)), (stop, z - fall * (stop - x)), slope))
    return corners


def _by_stretch(terrain: Terrain, corners: list[Corner]) -> Iterator[list[Corner]]:
    """The segments between one step and the next."""
    for stretch in terrain.stretches():
        built = [corners[index] for index in stretch if index < len(corners)]
        if built:
            yield built


def _tilt(slope: float) -> list[float]:
    """Quaternion that turns a level body down by `slope`, about +y."""
    return [math.cos(slope / 2), 0.0, math.sin(slope / 2), 0.0]


def _add_plane(spec: mujoco.MjSpec, terrain: Terrain) -> None:
    slope = terrain.angle[0]
    spec.worldbody.add_geom(
        spec.find_default("terrain"),
        name="ground_0",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[0.0, _HALF_WIDTH, 0.05],
        pos=[terrain.x[0] - FOOT_RADIUS * math.sin(slope), 0.0, terrain.z[0] - FOOT_RADIUS * math.cos(slope)],
        quat=_tilt(slope),
    )


def _add_box(
    spec: mujoco.MjSpec, name: str, start: tuple[float, float], stop: tuple[float, float], slope: float
) -> None:
    """One segment as a box whose upper face, raised by the foot's radius, is the profile."""
    depth = FOOT_RADIUS + _THICKNESS / 2
    spec.worldbody.add_geom(
        spec.find_default("terrain"),
        name=name,
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[math.dist(start, stop) / 2, _HALF_WIDTH, _THICKNESS / 2],
        pos=[
            (start[0] + stop[0]) / 2 - depth * math.sin(slope),
            0.0,
            (start[1] + stop[1]) / 2 - depth * math.cos(slope),
        ],
        quat=_tilt(slope),
    )


def _add_heightfields(
    spec: mujoco.MjSpec, name: str, stretch: list[tuple[tuple[float, float], tuple[float, float]]]
) -> None:
    """A stretch as heightfields of two rows, every column on a break of the profile.

    A heightfield's columns are equidistant, so neighbouring segments share one only while their widths are equal
    (rough ground, surveyed trails); the profile itself is never resampled.
    """
    runs: list[list[tuple[tuple[float, float], tuple[float, float]]]] = []
    for segment in stretch:
        width = segment[1][0] - segment[0][0]
        if runs and math.isclose(width, runs[-1][-1][1][0] - runs[-1][-1][0][0], rel_tol=1e-9):
            runs[-1].append(segment)
        else:
            runs.append([segment])
    for index, run in enumerate(runs):
        nodes = [run[0][0], *(stop for _, stop in run)]
        slopes = [math.atan2(a[1] - b[1], b[0] - a[0]) for a, b in pairwise(nodes)]
        # lowered along the normal: by r / cos(slope) in z, at a node by the mean of the two segments that meet there
        lowering = [FOOT_RADIUS / math.cos(slope) for slope in slopes]
        padded = [lowering[0], *lowering, lowering[-1]]
        heights = np.array([z - (padded[k] + padded[k + 1]) / 2 for k, (_, z) in enumerate(nodes)])
        lowest = float(heights.min())
        rise = float(heights.max()) - lowest
        elevation = rise if rise > 0.0 else 1e-3  # MuJoCo stretches the data to 0..1, and refuses a zero scale
        relative = (heights - lowest) / elevation
        spec.add_hfield(
            name=f"{name}_{index}",
            size=[(nodes[-1][0] - nodes[0][0]) / 2, _HALF_WIDTH, elevation, _THICKNESS],
            nrow=2,
            ncol=len(nodes),
            userdata=np.concatenate([relative, relative]),
        )
        spec.worldbody.add_geom(
            spec.find_default("terrain"),
            name=f"{name}_{index}",
            type=mujoco.mjtGeom.mjGEOM_HFIELD,
            hfieldname=f"{name}_{index}",
            pos=[(nodes[0][0] + nodes[-1][0]) / 2, 0.0, lowest],
        )


def _add_riser(spec: mujoco.MjSpec, name: str, terrain: Terrain, index: int, leaning: bool) -> None:
    """A thin frictionless plate with a bevelled top before the vertical face of the step at a segment's start.

    Args:
        spec: The scene.
        name: Of the plate; the bevel's has a suffix.
        terrain: The ground.
        index: Of the segment.
        leaning: Whether the upper tread is a tilted box; its end face then leans out at its foot, and the plate stands
            before that, too.
    """
    x, top, rise = terrain.x[index], terrain.z[index], terrain.rises[index]
    upper, lower = max(top, top - rise), min(top, top - rise)
    facing = -1.0 if rise > 0.0 else 1.0  # the face looks toward the lower side
    proud = _RISER_PROUD + (_lean(terrain, index) if leaning else 0.0)
    edge = upper - FOOT_RADIUS - _LIP
    foot_of_bevel = edge - _BEVEL * proud
    if foot_of_bevel <= lower:
        return  # lower than the bevel: nothing to strike
    height = foot_of_bevel - (lower - _THICKNESS / 2)
    thickness = proud + _RISER_BACK
    spec.worldbody.add_geom(
        spec.find_default("riser"),
        name=name,
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[thickness / 2, _HALF_WIDTH, height / 2],
        pos=[x + facing * (proud - thickness / 2), 0.0, foot_of_bevel - height / 2],
    )
    # the bevel: a box whose outer face runs from the tread's edge down and out to the plate's
    steepness = math.atan(_BEVEL)
    length, depth = math.hypot(proud, _BEVEL * proud), min(proud, 1e-3)
    outward = facing * math.sin(steepness), math.cos(steepness)
    spec.worldbody.add_geom(
        spec.find_default("riser"),
        name=f"{name}_bevel",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[length / 2, _HALF_WIDTH, depth / 2],
        pos=[
            x + facing * proud / 2 - outward[0] * depth / 2,
            0.0,
            (edge + foot_of_bevel) / 2 - outward[1] * depth / 2,
        ],
        quat=_tilt(facing * steepness),
    )


def _lean(terrain: Terrain, index: int) -> float:
    """How far the end face of a tilted box leans out over the face of the step at a segment's start, m."""
    rise = terrain.rises[index]
    gradient = terrain.gradients[index] if rise > 0.0 else -terrain.gradients[index - 1]
    return max(0.0, -gradient) * abs(rise)


def _add_edge(spec: mujoco.MjSpec, name: str, x: float, z: float, rise: float) -> None:
    """A stripe across the ground where the slope changes (dark) or a step stands (red); for the eye only."""
    spec.worldbody.add_geom(
        spec.find_default("edge"),
        name=name,
        size=[0.006, _HALF_WIDTH + 0.002, 0.0015],
        pos=[x, 0.0, max(z, z - rise)],
        material="step_edge" if rise != 0.0 else "slope_edge",
    )
