"""One `mujoco.MjModel` of the robot's MJCF and a terrain.

The robot (`models/compass.xml` and its neighbours) and its surroundings (`models/surroundings.xml`) are files;
this module replaces their numbers by the robot's parameters, and their floor by the terrain
(`mjbiped.engines.mujoco.ground`), with `mujoco.MjSpec`. Feet are spheres of radius `FOOT_RADIUS` about the legs' ends;
round feet are spheres about their arcs' centres, with `FOOT_RADIUS` added to the arcs' radius.

MuJoCo spends some 10 ns on every geom at every step, and its compiler's time grows faster than their number. So of a
terrain of more than `FEW_SEGMENTS` segments only a window about the robot is built, and near its end the next window's
model takes over the state. The pieces are cut by the terrain alone and stand in one coordinate system: every contact is
bitwise that of the whole terrain, whatever window it was found in.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from itertools import pairwise
from pathlib import Path

from mjbiped.engines.mujoco.callback import python_removed
from mjbiped.engines.mujoco.collisions import LOCK_STIFFNESS, PUSHED_OUT, STIFFNESS
from mjbiped.engines.mujoco.ground import FOOT_RADIUS, Ground, Piece
from mjbiped.engines.mujoco.scenery import add_arc, add_section
from mjbiped.engines.mujoco.surface import add_surface
from mjbiped.errors import InputError
from mjbiped.robots.bodies import Foot, Limb, Segment
from mjbiped.robots.robot import Robot
from mjbiped.terrain.profile import GROUND_FRICTION
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.mujoco import mujoco

SMALLEST_HIP_MASS = 1e-7
"""MuJoCo's compiler refuses a moving body without mass; this part of the robot's mass is invisible in every figure."""

SMALLEST_INERTIA = 2e-10
"""The same for a link without inertia about its centre of mass, in its mass times leg length squared."""

START_DEPTH = 1e-6
"""Of the first stance foot, m: exactly on the surface it may touch a heightfield's inner edge."""

CORNERS = 16
"""Contacts of a box sole that its sensor has room for; those that are more are the least deep."""


def check_masses(robot: Robot) -> None:
    """Refuse a robot with a body that MuJoCo's compiler takes for one without mass or inertia, or with more bodies.

    Raises:
        InputError: It has one, or weighs more than its `bodies`, which are all that the scene is made of.
    """
    bodies = robot.bodies
    foot_mass = bodies.foot.mass if bodies.foot else 0.0
    legs = len({limb.hinge for limb in bodies.limbs})  # the spokes of a wheel are one body on one hinge
    built = bodies.hip_mass + legs * (sum(segment.mass for segment in bodies.leg) + foot_mass)
    if not math.isclose(built, robot.total_mass, rel_tol=1e-9):
        raise InputError(
            f"MuJoCo's scene is made of the robot's `bodies`, a hip and legs, of {built:g} kg, and a "
            f"{type(robot).__name__} weighs {robot.total_mass:g} kg; walk it with engine='hybrid', which takes its "
            "linkages"
        )
    values = {segment.name: min(segment.mass, _inertia(segment, robot.leg_length)) for segment in bodies.leg}
    values["hip"] = _hip_mass(robot)
    if bodies.foot is not None:
        values["foot"] = min(bodies.foot.mass, bodies.foot.inertia)
    body = min(values, key=values.__getitem__)
    if values[body] < mujoco.mjMINVAL:
        names = [name for name in robot.numbers() if name.endswith(("mass", "inertia"))]
        given = ", ".join(f"{name} = {getattr(robot, name):g}" for name in names)
        raise InputError(
            f"{given}: too light for MuJoCo, which has {values[body]:.2g} kg or kg m^2 for the {body}; expected at "
            f"least {mujoco.mjMINVAL:g}: give greater masses or inertias, or engine='hybrid', which takes any"
        )


def scene_spec(robot: Robot, ground: Ground, pieces: list[Piece], *, timestep: float) -> mujoco.MjSpec:
    """Build the scene of a robot on a part of a terrain, which MuJoCo can compile or write as a file.

    Args:
        robot: The robot's parameters.
        ground: The terrain, cut into pieces.
        pieces: Those to be built.
        timestep: Of the steps that the contacts are made for, s; see `mjbiped.engines.mujoco.scene`.

    Raises:
        InputError: The robot is too light; see `check_masses`.
    """
    check_masses(robot)
    spec = mujoco.MjSpec.from_file(str(models_folder() / robot.bodies.scene))
    _set_robot(spec, robot, timestep)
    spec.delete(spec.geom("floor"))
    ground.add_to(spec, pieces)
    for key in list(spec.keys):
        spec.delete(key)  # they hold Table I's postures on a 2 degree slope
    return spec


def first_state(
    robot: Robot, terrain: Terrain, q: Sequence[float], dq: Sequence[float]
) -> tuple[list[float], list[float]]:
    """Place the first stance foot at x = 0 under a straight leg.

    Args:
        robot: The robot.
        terrain: The ground's profile.
        q: Angles from the ground's normal under x = 0, stance leg first, rad.
        dq: Their rates, rad/s.

    Returns:
        The posture and its rates, in the order of `robot.places`, m, rad, m/s and rad/s.
    """
    slope, radius = terrain.slope_at(0.0), robot.radius
    length, forward, upward = robot.leg_length - radius, radius * math.sin(slope), radius * math.cos(slope)
    place = (forward, terrain.height_at(0.0) + upward)
    posture = list(robot.posture(place, 0, [angle + slope for angle in q], slope=slope))
    posture[1] -= START_DEPTH
    leg = q[0] + slope
    # a round foot rolls; `posture` is linear in the angles behind the hip's place, so it also maps rates
    along, up = length * math.cos(leg) + upward, -length * math.sin(leg) - forward
    rates = [along * dq[0], up * dq[0], *robot.posture((0.0, 0.0), 0, dq)[2:]]
    return posture, rates


def models_folder() -> Path:
    """Folder of the MJCF files, in a checkout as in an installed wheel."""
    package = Path(str(resources.files("mjbiped")))
    installed = package / "models"
    return installed if installed.is_dir() else package.parent / "models"


def _set_robot(spec: mujoco.MjSpec, robot: Robot, timestep: float) -> None:
    """Write the robot's parameters, the timestep and the damping that belongs to it over the spec."""
    spec.option.timestep = timestep
    spec.option.gravity = [0.0, 0.0, -robot.gravity]
    length, bodies = robot.leg_length, robot.bodies
    spec.body("hip").mass = _hip_mass(robot)
    if bodies.hip_inertia:
        spec.body("hip").inertia = [bodies.hip_inertia] * 3
    for shown in spec.body("hip").geoms:
        shown.size, shown.fromto = length * shown.size, length * shown.fromto
    riser = spec.find_default("riser").geom
    riser.solref[:2] = [-PUSHED_OUT / timestep, -1.0 / timestep]
    stop = [-LOCK_STIFFNESS, -1.0 / timestep]
    for lock in spec.equalities:
        lock.solref[:2] = stop
    for limb in bodies.limbs:
        side, y = limb.name, length * limb.across
        if spec.geom(f"{side}_tip") is None:
            _add_leg(spec, bodies.limbs[0].name, side)
        for segment in bodies.leg:
            _set_segment(spec, limb, segment, length)
        if limb.aside:
            ends = abs(limb.aside) + 0.025 * length
            spec.geom("hip_visual").fromto = [0.0, -ends, 0.0, 0.0, ends, 0.0]
            spec.body(f"{side}_{bodies.leg[0].name}").pos = [0.0, limb.aside, 0.0]
        for upper, lower in pairwise(bodies.leg):
            spec.body(f"{side}_{lower.name}").pos = _down(limb, upper, upper.length, 0.0)
            kneecap = spec.geom(f"{side}_kneecap")
            kneecap.size, kneecap.pos = length * kneecap.size, _down(limb, upper, upper.length, y)
            spec.joint(f"{side}_knee").solref_limit[:2] = stop
        last = bodies.leg[-1]
        shown = spec.geom(f"{side}_{last.name}")
        shown.fromto = [0.0, y, 0.0, *_down(limb, last, last.length - 0.018 * length, y)]
        feet = [spec.geom(name) for name in bodies.feet(limb)]
        if bodies.foot is not None:
            _set_foot(spec, limb, bodies.foot, last.length, length)
        else:
            _set_end(spec, robot, limb, last)
        for foot in feet:
            foot.friction[0] = GROUND_FRICTION
            foot.solref[:2] = [-STIFFNESS, -1.0 / timestep]


def _hip_mass(robot: Robot) -> float:
    """Mass of the hip's body, kg."""
    return max(robot.bodies.hip_mass, SMALLEST_HIP_MASS * robot.total_mass)


def _inertia(segment: Segment, length: float) -> float:
    """Inertia of a segment's body about its centre of mass, kg m^2, in a robot of that leg length, m."""
    return max(segment.inertia, SMALLEST_INERTIA * segment.mass * length**2)


def _set_end(spec: mujoco.MjSpec, robot: Robot, limb: Limb, last: Segment) -> None:
    """Write the end of a leg's last segment, a point or a round foot, over its geoms."""
    length, y, end = robot.leg_length, robot.leg_length * limb.across, last.length
    foot, tip = spec.geom(f"{limb.name}_foot"), spec.geom(f"{limb.name}_tip")
    foot.pos = _down(limb, last, end - robot.radius, 0.0)
    foot.size = [robot.radius + FOOT_RADIUS, 0.0, 0.0]
    tip.size = length * tip.size
    tip.pos = _down(limb, last, end - tip.size[0], y)
    if robot.radius:
        add_arc(tip, robot.radius, last.turn, _down(limb, last, end - robot.radius, y))


def _set_foot(spec: mujoco.MjSpec, limb: Limb, foot: Foot, last: float, length: float) -> None:
    """Write a foot's parameters over its body and geoms, and delete the geoms of the other kind of foot."""
    tip, sole = spec.geom(f"{limb.name}_tip"), spec.geom(f"{limb.name}_sole")
    heel, toe = spec.geom(f"{limb.name}_heel"), spec.geom(f"{limb.name}_toe")
    y, body = length * limb.across, tip.parent
    body.pos, body.mass, body.inertia = [0.0, 0.0, -last], foot.mass, [foot.inertia] * 3
    tip.size, tip.pos = length * tip.size, [0.0, y, 0.0]
    heel.pos, toe.pos = [-foot.behind, 0.0, -foot.height], [foot.ahead, 0.0, -foot.height]
    thick = 0.2 * foot.height
    sole.size = [0.5 * (foot.behind + foot.ahead), length * sole.size[1], thick]
    sole.pos = [0.5 * (foot.ahead - foot.behind), y, thick - foot.height]
    shoe = spec.geom(f"{limb.name}_shoe")
    shoe.size = [0.8 * sole.size[0], 0.8 * sole.size[1], 0.8 * foot.height]
    shoe.pos = [sole.pos[0], y, -0.6 * foot.height]
    if foot.box:
        of = spec.find_default("foot").geom
        sole.contype, sole.condim, sole.priority, sole.solimp = of.contype, of.condim, of.priority, of.solimp
        sole.pos[2] -= FOOT_RADIUS  # as the ground lies lower by it
        spec.sensor(f"{limb.name}_contact").intprm[2] = CORNERS
        spec.delete(heel)
        spec.delete(toe)


def _add_leg(spec: mujoco.MjSpec, first: str, name: str) -> None:
    """Add a leg that the robot's file does not hold to the body of the first one, with the same parts."""
    for geom in [geom for geom in spec.geoms if geom.name.startswith(f"{first}_")]:
        copy = geom.parent.add_geom(geom.classname, name=name + geom.name.removeprefix(first))
        copy.type, copy.size, copy.material = geom.type, geom.size, geom.material
    felt = spec.sensor(f"{first}_contact")
    kinds = {"type": felt.type, "objtype": felt.objtype, "intprm": felt.intprm}
    spec.add_sensor(name=f"{name}_contact", objname=f"{name}_foot", **kinds)


def _down(limb: Limb, segment: Segment, distance: float, y: float) -> list[float]:
    """Place on a segment at a distance (m) from its hinge, in the hinge's frame; y is across the walking direction."""
    turn = limb.offset + segment.turn
    return [0.0 - distance * math.sin(turn), y, -distance * math.cos(turn)]


def _set_segment(spec: mujoco.MjSpec, limb: Limb, segment: Segment, length: float) -> None:
    """Write a segment's parameters over its body; what is seen of it is as thick as befits the leg's length."""
    name, y = f"{limb.name}_{segment.name}", length * limb.across
    shown, bulge = spec.geom(name), spec.geom(f"{name}_mass")
    body = shown.parent
    body.mass = segment.mass
    x, z = segment.place(segment.centre, segment.offset)
    body.ipos = [x, 0.0, z]
    across = _inertia(segment, length)
    body.inertia = [across, across, across if segment.axial is None else segment.axial]
    shown.size, bulge.size = length * shown.size, length * bulge.size
    bulge.size[2] = min(bulge.size[2], max(bulge.size[0], min(segment.centre, segment.length - segment.centre)))
    shown.fromto = [0.0, y, 0.0, *_down(limb, segment, segment.length, y)]
    bulge.pos = _down(limb, segment, segment.centre, y)


MARGIN = 2.0
"""Ground about the hip that is never missing, in leg lengths: a leg, and what a fall can go."""

_COARSE = 64
"""Pixels of a texture's edge in models that are stepped: viewers show them, too, and they are compiled in no time."""


@dataclass(frozen=True)
class Scene:
    """A compiled scene."""

    model: mujoco.MjModel
    pieces: list[Piece]  # of the ground, those that were built
    start: float  # where the ground begins, x in m
    end: float  # where it ends, x in m: the terrain's own end, or as far as was built
    inside: tuple[float, float]  # between which x (m) it has all ground about the hip; infinite: there is no more


@dataclass(frozen=True)
class GroundWindows:
    """Builds the scene about any place of a terrain.

    Attributes:
        robot: The robot.
        ground: The terrain, cut into pieces.
        timestep: Of the steps that the contacts are made for, s. Their damping is 1 / timestep: with it an impact is
            plastic within one step.
        margin: Ground about the hip that is never missing, m; `MARGIN` leg lengths or more.
        userdata: Number of floats in `mjData.userdata`.
        scenery: For pictures: the ground cut open, or as a surface, and fine textures, which take 5 MB and 12 ms.
    """

    robot: Robot
    ground: Ground
    timestep: float
    margin: float
    userdata: int = 0
    scenery: bool = False

    def about(self, x: float) -> Scene:
        """Build the scene about a hip at x (m)."""
        ground, pieces = self.ground, self.ground.window(x, self.margin, self.robot.leg_length)
        with python_removed():
            spec = scene_spec(self.robot, ground, pieces, timestep=self.timestep)
            spec.nuserdata = self.userdata
            first, last = pieces[0].segments[0], pieces[-1].segments[-1]
            begins, ends = first == 0, last == len(ground.stops) - 1
            sight = -math.inf, math.inf
            if self.scenery and "hip_y" in self.robot.places:
                sight = add_surface(spec, ground, pieces, self.robot.leg_length, x)
            elif self.scenery:
                add_section(spec, ground, pieces, self.robot.leg_length)
            else:
                for texture in spec.textures:
                    texture.width = texture.height = _COARSE
            model = spec.compile()
        start, end = ground.starts[first], ground.stops[last]
        inside = -math.inf if begins else start + self.margin, math.inf if ends else end - self.margin
        inside = max(inside[0], sight[0]), min(inside[1], sight[1])
        return Scene(model, pieces, start, end, inside)
