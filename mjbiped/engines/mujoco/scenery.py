"""What makes a picture of the ground and is no part of its physics."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

_DEPTH = 0.6  # of the earth seen at the ground's sides, m
_LOWERED = 1e-3  # its upper edge lies below the ground's, m
_PROUD = 3e-4  # how far a painted riser stands before its face, m
_GAP = 4e-3  # between the ground's side and the earth, m: no two faces in one plane


def add_earth(spec: mujoco.MjSpec, profile: Sequence[tuple[float, float]], half_width: float) -> None:
    """Add walls along both sides of the ground, down from its profile; nothing can touch them.

    Args:
        spec: The scene, with a default class "scenery".
        profile: Points (x, z) of the ground, m; two above each other where there is a step.
        half_width: Of the ground across the walking direction, m.
    """
    x, z = np.array(profile).T
    out = half_width + _GAP
    rows = [
        np.stack([x, np.full_like(x, y), z - lowering], axis=1) for y in (-out, out) for lowering in (_LOWERED, _DEPTH)
    ]
    near_top, near_foot, far_top, far_foot = (np.arange(len(x)) + k * len(x) for k in range(4))
    # two triangles per piece and side, counterclockwise as seen from outside
    faces = [
        [foot[:-1], foot[1:], top[1:], foot[:-1], top[1:], top[:-1]]
        for foot, top in ((near_foot, near_top), (far_foot[::-1], far_top[::-1]))
    ]
    spec.add_mesh(
        name="earth",
        uservert=np.concatenate(rows).ravel(),
        userface=np.concatenate([np.stack(side, axis=1).ravel() for side in faces]),
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
    )
    spec.worldbody.add_geom(spec.find_default("scenery"), name="earth", meshname="earth")


def add_faces(spec: mujoco.MjSpec, faces: Sequence[tuple[float, float, float]], half_width: float) -> None:
    """Paint the risers' faces; the plates that a foot strikes stand within the ground.

    Args:
        spec: The scene, with a default class "edge".
        faces: Of each its position x, and the ground's height before and after it, m.
        half_width: As in `add_earth`, m.
    """
    for index, (x, before, after) in enumerate(faces):
        facing = -1.0 if after > before else 1.0
        low, high = min(before, after), max(before, after) - 2.0 * _PROUD
        if high > low:
            spec.worldbody.add_geom(
                spec.find_default("edge"),
                name=f"face_{index}",
                size=[_PROUD / 2, half_width, (high - low) / 2],
                pos=[x + facing * _PROUD / 2, 0.0, (high + low) / 2],
                material="riser",
            )
