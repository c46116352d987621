"""Long terrains: the model holds a window of the ground about the robot, so a step costs the same on any length.

MuJoCo takes in every geom at every step, some 10 ns each, and its compiler is slower than in proportion. So of a
terrain of more than `FEW_SEGMENTS` segments only those about the robot are built, and near the window's end the next
window's model takes over the state. The pieces of the ground are cut by the terrain alone
(`mjbiped.engines.mujoco.ground`) and stand in one coordinate system: every contact is bitwise that of the whole
terrain, whatever window it was found in.
"""

from __future__ import annotations

import cmath
import math
from functools import partial
from typing import Any

import numpy as np

from mjbiped.engines.mujoco.callback import python_removed
from mjbiped.engines.mujoco.ground import FEW_SEGMENTS, Ground
from mjbiped.engines.mujoco.legs import Leg
from mjbiped.engines.mujoco.scene import Scene, compose_scene
from mjbiped.robots.bodies import Limb
from mjbiped.robots.robot import Robot
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.mujoco import mujoco

MARGIN = 2.0
"""Ground about the hip that is never missing, in leg lengths: a leg, and what a fall can go."""

_AHEAD = 20.0  # of the hip in a new window, in leg lengths, while these are few segments
_TURN = 1.0  # behind the margin, in leg lengths: who turns back and forth does not build at each turn
_LEAST = 3.0  # ahead of the margin, in leg lengths, of however many segments


class GroundWindows:
    """Builds the scene about any place of a terrain.

    Attributes:
        start: Where the whole ground begins, x in m.
        end: Where it ends, x in m.
    """

    def __init__(
        self,
        robot: Robot,
        terrain: Terrain,
        *,
        timestep: float,
        reach: float,
        ground: str = "auto",
        userdata: int = 0,
        scenery: bool = False,
        margin: float | None = None,
    ) -> None:
        """Cut the terrain; nothing is built yet.

        Args:
            robot: See `mjbiped.engines.mujoco.scene.compose_scene` for this and all that follows but the last.
            terrain: The ground's profile.
            timestep: Physics step, s.
            reach: How far ahead of x = 0 the last segment must reach, m.
            ground: Kind of ground.
            userdata: Number of floats in `mjData.userdata`.
            scenery: Add the ground as it is seen from the side, for pictures.
            margin: Ground about the hip that is never missing, m; `MARGIN` legs by default.

        Raises:
            InputError: `ground` is unknown.
        """
        self._terrain, self._length = terrain, robot.leg_length
        self._margin = MARGIN * robot.leg_length if margin is None else margin
        self._ground = Ground(terrain, reach=reach, kind=ground)
        self._compose = partial(
            compose_scene, robot, self._ground, timestep=timestep, userdata=userdata, scenery=scenery
        )
        self.start, self.end = self._ground.start_of(0), self._ground.end

    def segments_about(self, x: float) -> range:
        """The segments to be built for a hip at x (m); all where they are few."""
        starts, length = self._terrain.x, self._length
        if len(starts) <= FEW_SEGMENTS:
            return self._ground.segments
        few = starts[min(self._terrain.segment_at(x) + FEW_SEGMENTS, len(starts) - 1)]
        ahead = max(self._margin + _LEAST * length, min(self._margin + _AHEAD * length, few - x))
        return self._ground.between(x - self._margin - _TURN * length, x + ahead)

    def about(self, x: float) -> Scene:
        """Build the scene about a hip at x (m)."""
        with python_removed():
            return self._compose(self.segments_about(x))

    def inside(self, scene: Scene) -> tuple[float, float]:
        """Between which places (m) a scene has all ground about the hip; infinite where nothing more can be built."""
        first, last = scene.segments[0] == 0, scene.segments[-1] == len(self._terrain.x) - 1
        return -math.inf if first else scene.start + self._margin, math.inf if last else scene.end - self._margin


def places_in(scene: Scene, terrain: Terrain, robot: Robot) -> dict[str, Any]:
    """Where things are in a scene, as fields of `state.Constants`: ground, joints, geoms, and sensor data."""
    model, bodies, begin = scene.model, robot.bodies, scene.segments.start
    shown = slice(begin, scene.segments.stop)
    x, z, gradient = map(np.array, terrain.profile[:3])
    pieces = [(model.geom(name).id, piece) for name, piece in scene.pieces.items()]
    grounds = [next((geom, piece) for geom, piece in pieces if segment in piece) for segment in scene.segments]
    risers, sills = (
        [float(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, f"{kind}_{segment}")) for segment in scene.segments]
        for kind in ("riser", "sill")
    )
    return {
        "legs": [_leg_in(model, limb, robot) for limb in bodies.limbs],
        "leg_count": len(bodies.limbs),
        "order": [float(model.joint(name).qposadr[0]) for name in robot.places],
        "coordinates": model.nq,
        "angles": len(robot.angles),
        "hip": mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, "hip"),
        "slots": int(model.sensor(f"{bodies.limbs[0].name}_contact").dim[0]),
        "sensed": model.nsensordata,
        "actuators": model.nu,
        "geoms": model.ngeom,
        "joints": model.njnt,
        "locks": model.neq,
        "x": x[shown].tolist(),
        # the centres of round feet meet the ground as points meet one that lies higher by their radius
        "z": (z[shown] + robot.radius * np.hypot(1.0, gradient[shown])).tolist(),
        "gradient": gradient[shown].tolist(),
        "segments": len(scene.segments),
        "rises": [float(rise) for rise in terrain.rises[shown]],
        "pieces": [float(geom) for geom, _ in grounds],
        "firsts": [float(max(piece[0] - begin, 0)) for _, piece in grounds],
        "lasts": [float(min(piece[-1] - begin, len(scene.segments) - 1)) for _, piece in grounds],
        "risers": risers,
        "sills": sills,
    }


def _lengths(robot: Robot) -> list[float]:
    """Lengths of a leg's segments down to the foot, or to the centre of a round one, m."""
    *upper, last = (segment.length for segment in robot.bodies.leg)
    return [*upper, last - robot.radius]


def _leg_in(model: mujoco.MjModel, limb: Limb, robot: Robot) -> Leg:
    """Where a leg's parts are in a model; of two segments the leg has a knee."""
    name, lengths, turns = limb.name, _lengths(robot), [segment.turn for segment in robot.bodies.leg]
    foot, geoms = robot.bodies.foot, [int(model.geom(part).id) for part in robot.bodies.feet(limb)]
    straight = sum(length * cmath.exp(1j * turn) for length, turn in zip(lengths, turns, strict=True))
    more: dict[str, Any] = {}
    if foot is not None:
        more = {"height": foot.height, "behind": foot.behind, "ahead": foot.ahead}
        more |= {"sole": int(model.joint(f"{name}_foot").qposadr[0]), "toe": geoms[1] if len(geoms) > 1 else -1}
    if len(lengths) > 1:
        knee = model.joint(f"{name}_knee")
        more |= {"knee": int(knee.qposadr[0]), "lower": lengths[1], "bend": turns[1], "stop": int(knee.id)}
        more |= {"motor": int(model.actuator(f"{name}_knee").id), "lock": int(model.equality(f"{name}_lock").id)}
    return Leg(
        hip=int(model.joint(limb.hinge).qposadr[0]),
        offset=limb.offset,
        lap=limb.lap,
        upper=lengths[0],
        foot=geoms[0],
        contacts=int(model.sensor(f"{name}_contact").adr[0]),
        ankle=int(model.actuator(limb.ankle).id),
        turn=turns[0],
        reach=abs(straight),
        **more,
    )
