"""The kneed biped's postures as MuJoCo has them, and what its feet meet and feel."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjbiped.engines.mujoco.callbacks import Places, beside, meets
from mjbiped.engines.mujoco.contact_events import SMALLEST_UPWARD_NORMAL
from mjbiped.robots.kneed import KneedBiped

Array = NDArray[np.float64]
X, Z = 0, 1
THIGHS, KNEES = (2, 4), (3, 5)  # of the left and the right leg, in qpos and qvel
PLACES = [X, Z, *THIGHS, *KNEES]  # qpos in the order of `KneedBiped.places`


def foot_of(robot: KneedBiped, qpos: Any, leg: int) -> tuple[float, float]:
    """Place of a foot, x and z in m."""
    thigh = qpos[THIGHS[leg]]
    shank = thigh + qpos[KNEES[leg]]
    upper, lower = robot.thigh_length, robot.shank_length
    x = qpos[X] - upper * math.sin(thigh) - lower * math.sin(shank)
    return x, qpos[Z] - upper * math.cos(thigh) - lower * math.cos(shank)


class Felt(NamedTuple):
    """What a foot feels in the step just resolved.

    Attributes:
        force: Sum of all normal forces, N.
        bearing: Of those of the ground, and not of a riser's face, N.
        tangential: Force along the ground, N.
        depth: Of the deepest contact with the ground, m.
        ground: Whether it touches the ground.
        face: Whether it touches a riser's face.
    """

    force: float
    bearing: float
    tangential: float
    depth: float
    ground: bool
    face: bool


def felt(model: mujoco.MjModel, data: mujoco.MjData, foot: int) -> Felt:
    """The contacts of a foot."""
    force = bearing = across = along = depth = 0.0
    ground = face = False
    wrench = np.zeros(6)
    for index in range(data.ncon):
        contact = data.contact[index]
        if foot not in (contact.geom1, contact.geom2) or contact.efc_address < 0:
            continue
        upward = contact.frame[2] * (1.0 if foot == contact.geom2 else -1.0)
        mujoco.mj_contactForce(model, data, index, wrench)
        force += wrench[0]
        if upward < SMALLEST_UPWARD_NORMAL:
            face = True
            continue
        ground = True
        depth = max(depth, -contact.dist)
        bearing, across, along = bearing + wrench[0], across + wrench[1], along + wrench[2]
    return Felt(force, bearing, math.hypot(across, along), depth, ground, face)


class Collisions:
    """Says by bits in `geom_conaffinity` what either foot can meet; see `mjbiped.engines.mujoco.callbacks.refuses`."""

    def __init__(self, model: mujoco.MjModel, places: Places) -> None:
        """Of a scene whose feet collide by a bit each."""
        self._model, self._places = model, places
        self._ground = [g for g in range(model.ngeom) if model.geom_bodyid[g] == 0 and model.geom_conaffinity[g]]
        model.body_conaffinity[0] = 3
        self._bits = np.zeros((2, len(self._ground)), dtype=np.int32)

    def stand(self, leg: int, x: float, z: float) -> None:
        """A foot stands at x, z: it meets all ground but what stands beside it."""
        self._bits[leg] = [not beside(self._places, x, z, geom) for geom in self._ground]

    def swing(self, leg: int, x: float, z: float) -> None:
        """A foot moves at x, z: it is a point, which meets the piece that it is over, and a riser beside it."""
        self._bits[leg] = [meets(self._places, x, z, geom) for geom in self._ground]

    def write(self, *, lifted: int | None = None) -> None:
        """Write it into the model; the foot of the leg `lifted` passes through all."""
        left, right = (0 * bits if leg == lifted else bits for leg, bits in enumerate(self._bits))
        self._model.geom_conaffinity[self._ground] = left + 2 * right
