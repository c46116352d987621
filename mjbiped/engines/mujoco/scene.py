"""Robot MJCF and terrain to one `mujoco.MjModel`.

The robot (`models/compass.xml`, `models/kneed.xml`) and its surroundings (`models/surroundings.xml`) stand in files;
this module writes the robot's parameters over it and puts the terrain in the floor's place
(`mjbiped.engines.mujoco.ground`), with `mujoco.MjSpec`. Feet are spheres of radius `FOOT_RADIUS` about the legs' ends.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

import mujoco

from mjbiped.engines.mujoco.ground import FOOT_RADIUS, Ground
from mjbiped.engines.mujoco.scenery import add_section
from mjbiped.engines.mujoco.step_size import STIFFNESS
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot
from mjbiped.terrain.segments import GROUND_FRICTION

SMALLEST_HIP_MASS = 1e-7
"""MuJoCo's compiler refuses a moving body without mass; this part of the robot's mass is invisible in every figure."""

SMALLEST_INERTIA = 2e-10
"""The same for a link without inertia about its centre of mass, in its mass times leg length squared."""

LOCK_STIFFNESS = 1e5
"""Of a locked or stopped knee over the inertia that it meets, 1/s². `solimp` leaves 1e-4 of the load unborne, and a
light shank under the robot's weight would be turned at some 1e3 rad/s²: so it bends by 1e-6 rad."""

PUSHED_OUT = 100.0
"""Share of its depth by which a foot comes out of a riser's face again, 1/s: in 10 ms, before it slides down to the
ground, whose edge it would miss by that depth."""

COARSE = 64
"""Pixels of a texture's edge in models that are stepped: viewers show them, too, and they are compiled in no time."""

RECORDS = "walks"
"""The model's one numeric field, of so many numbers: for `mjbiped.engines.mujoco.compiled.callbacks`, which says what
stands there."""
RECORDS_SIZE = 4

_SIDES = (("left", 0.04), ("right", -0.04))  # legs, and where they are seen across the walking direction, leg lengths


@dataclass(frozen=True)
class Scene:
    """A compiled scene.

    Attributes:
        model: The MuJoCo model; its `userdata` has the size asked for.
        segments: Of the terrain, those that were built.
        start: Where the ground begins, x in m.
        end: Where the ground ends, x in m: the terrain's own end, or as far as was built.
        pieces: Which segments each geom of the ground is made of, by its name.
    """

    model: mujoco.MjModel
    segments: range
    start: float
    end: float
    pieces: Mapping[str, range]


def compose_scene(
    robot: Robot, ground: Ground, segments: range, *, timestep: float, userdata: int, scenery: bool
) -> Scene:
    """Build the MuJoCo model of a robot on a part of a terrain.

    Args:
        robot: The robot's parameters.
        ground: The terrain, cut into pieces.
        segments: Those to be built; see `Ground.between`.
        timestep: Of the steps that the contacts are made for, s. Their damping is 1 / timestep: with it an impact is
            plastic within one step.
        userdata: Number of floats in `mjData.userdata`.
        scenery: For pictures: the ground cut open, and fine textures, which take 5 MB and 12 ms.

    Returns:
        The scene.
    """
    spec = mujoco.MjSpec.from_file(str(models_folder() / ("kneed_scene.xml" if robot.knees else "scene.xml")))
    spec.nuserdata = userdata
    spec.add_numeric(name=RECORDS, size=RECORDS_SIZE, data=[0.0] * RECORDS_SIZE)
    _set_robot(spec, robot, timestep)
    spec.delete(spec.geom("floor"))
    ground.add_to(spec, segments)
    if scenery:
        begins = segments[0] == 0
        add_section(spec, ground.profile(segments), robot.leg_length, begins=begins)
    else:
        for texture in spec.textures:
            texture.width = texture.height = COARSE
    for key in list(spec.keys):
        spec.delete(key)  # they hold Table I's postures on a 2 degree slope
    start, end = ground.start_of(segments[0]), ground.stop_of(segments[-1])
    return Scene(spec.compile(), segments, start, end, ground.pieces(segments))


def models_folder() -> Path:
    """Folder of the MJCF files, in a checkout as in an installed wheel."""
    package = Path(str(resources.files("mjbiped")))
    installed = package / "models"
    return installed if installed.is_dir() else package.parent / "models"


def _set_robot(spec: mujoco.MjSpec, robot: Robot, timestep: float) -> None:
    """Write the robot's parameters, the timestep and the damping that belongs to it over the spec."""
    spec.option.timestep = timestep
    spec.option.gravity = [0.0, 0.0, -robot.gravity]
    length = robot.leg_length
    if isinstance(robot, KneedBiped):
        _set_knees(spec, robot, timestep)
    else:
        assert isinstance(robot, Compass)
        _set_legs(spec, robot, timestep)
    hip = spec.geom("hip_visual")
    hip.size, hip.fromto = length * hip.size, length * hip.fromto
    riser = spec.find_default("riser").geom
    riser.solref[:2] = [-PUSHED_OUT / timestep, -1.0 / timestep]


def _set_legs(spec: mujoco.MjSpec, robot: Compass, timestep: float) -> None:
    """The compass biped's."""
    length = robot.leg_length
    spec.body("hip").mass = max(robot.hip_mass, SMALLEST_HIP_MASS * robot.total_mass)
    solref = [-STIFFNESS, -1.0 / timestep]
    for side, y in _SIDES:
        leg = spec.body(f"{side}_leg")
        leg.mass = robot.leg_mass
        leg.ipos = [0.0, 0.0, -robot.upper_length]
        leg.inertia = [max(robot.leg_inertia, SMALLEST_INERTIA * robot.leg_mass * length**2)] * 3
        foot = spec.geom(f"{side}_foot")
        foot.pos = [0.0, 0.0, -length]
        foot.size = [FOOT_RADIUS, 0.0, 0.0]
        foot.friction = [GROUND_FRICTION, 0.0, 0.0]
        foot.solref[:2] = solref
        # what is seen of a leg is as thick as befits its length
        shank, tip, mass = (spec.geom(f"{side}_{part}") for part in ("shank", "tip", "mass"))
        for geom in (shank, tip, mass):
            geom.size = length * geom.size
        shank.fromto = [0.0, length * y, 0.0, 0.0, length * y, -0.982 * length]
        tip.pos = [0.0, length * y, -0.976 * length]
        mass.pos = [0.0, length * y, -robot.upper_length]


def _set_knees(spec: mujoco.MjSpec, robot: KneedBiped, timestep: float) -> None:
    """The kneed biped's, its feet's contacts and its knees' stops and locks."""
    length, upper, lower = robot.leg_length, robot.thigh_length, robot.shank_length
    spec.body("hip").mass = max(robot.hip_mass, SMALLEST_HIP_MASS * robot.total_mass)
    for side, y in _SIDES:
        for link, centre in (("thigh", robot.thigh_centre), ("shank", robot.shank_centre)):
            body, mass = spec.body(f"{side}_{link}"), getattr(robot, f"{link}_mass")
            body.mass = mass
            body.ipos = [0.0, 0.0, -centre]
            body.inertia = [max(getattr(robot, f"{link}_inertia"), SMALLEST_INERTIA * mass * length**2)] * 3
            shown, bulge = spec.geom(f"{side}_{link}"), spec.geom(f"{side}_{link}_mass")
            shown.size, bulge.size = length * shown.size, length * bulge.size
            bulge.pos = [0.0, length * y, -centre]
        spec.body(f"{side}_shank").pos = [0.0, 0.0, -upper]
        spec.geom(f"{side}_thigh").fromto = [0.0, length * y, 0.0, 0.0, length * y, -upper]
        spec.geom(f"{side}_shank").fromto = [0.0, length * y, 0.0, 0.0, length * y, -lower + 0.018 * length]
        for part, height in (("kneecap", upper), ("tip", lower - 0.024 * length)):
            geom = spec.geom(f"{side}_{part}")
            geom.size, geom.pos = length * geom.size, [0.0, length * y, -height]
        foot = spec.geom(f"{side}_foot")
        foot.pos = [0.0, 0.0, -lower]
        foot.size = [FOOT_RADIUS, 0.0, 0.0]
        foot.friction = [GROUND_FRICTION, 0.0, 0.0]
        foot.solref[:2] = [-STIFFNESS, -1.0 / timestep]
        stop = [-LOCK_STIFFNESS, -1.0 / timestep]
        spec.joint(f"{side}_knee").solref_limit[:2] = stop
        spec.equality(f"{side}_lock").solref[:2] = stop
