"""What makes a picture of the ground and is no part of its physics: the ground cut open along the robot's path.

Seen from the side, the cut shows the ground in profile: filled, with a dark edge, and with thin level lines, against
which the eye sees a slope of a degree.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mjbiped.utils.mujoco import mujoco

CUT = 0.075
"""How far before the robot's plane the ground is cut, in leg lengths: just before its legs and feet."""

_BACK = 0.6  # of the ground behind the robot's plane, in leg lengths
_DEPTH = 2.0  # of the cut, in leg lengths
_BEYOND = 8.0  # ground seen behind its beginning, where the first segment goes on without end, in leg lengths
_EDGE = 0.011  # thickness of the profile's line, in leg lengths: four pixels
_LINE = 0.004  # thickness of a level line, in leg lengths: more than a pixel, or it would come and go
_PITCH = 0.1  # between level lines, in leg lengths, then rounded to a power of ten in m
_MOST_LINES = 300
_BEFORE = 5e-4  # of line before cut, and edge before line, in leg lengths: no two faces in one plane

Points = NDArray[np.float64]


def add_section(
    spec: mujoco.MjSpec, profile: Sequence[tuple[float, float]], leg_length: float, *, begins: bool
) -> None:
    """Add the ground as it is seen from the side; nothing can touch it.

    Args:
        spec: The scene, with a default class "scenery".
        profile: Points (x, z) of the ground, m; two above each other where there is a step.
        leg_length: Of the robot, m, which all that is seen follows.
        begins: Whether the terrain's first segment is the first here; it goes on backwards.
    """
    points = np.array(profile)
    if begins:
        fall = (points[1] - points[0]) / (points[1, 0] - points[0, 0])
        points = np.vstack([points[0] - _BEYOND * leg_length * fall, points])
    from_, to = points[:-1], points[1:]
    down, cut, before = np.array([0.0, _DEPTH * leg_length]), -CUT * leg_length, _BEFORE * leg_length
    _add_quads(spec, "earth", cut, from_, to, from_ - down, to - down)
    _add_quads(spec, "level_line", cut - before, *_level_lines(from_, to, leg_length))
    _add_quads(spec, "profile_line", cut - 2.0 * before, *_edges(from_, to, _EDGE * leg_length))
    back = _BACK * leg_length
    surface = np.concatenate([_at(cut, from_), _at(cut, to), _at(back, to), _at(back, from_)])
    _add_mesh(spec, "surface", surface)


def _at(y: float, points: Points) -> Points:
    """Points of the plane at y."""
    return np.insert(points, 1, y, axis=1)


def _add_quads(spec: mujoco.MjSpec, name: str, y: float, *corners: Points) -> None:
    """Add faces in the plane at y: upper left, upper right, lower left, lower right corners (x, z) of each."""
    upper_left, upper_right, lower_left, lower_right = (_at(y, each) for each in corners)
    _add_mesh(spec, name, np.concatenate([lower_left, lower_right, upper_right, upper_left]))


def _add_mesh(spec: mujoco.MjSpec, name: str, corners: Points) -> None:
    """Add four-cornered faces: all their first corners, all their second ones, and so on, counterclockwise."""
    count = len(corners) // 4
    a, b, c, d = (np.arange(count) + k * count for k in range(4))
    spec.add_mesh(
        name=name,
        uservert=corners.ravel(),
        userface=np.stack([a, b, c, a, c, d], axis=1).ravel(),
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
    )
    spec.worldbody.add_geom(spec.find_default("scenery"), name=name, meshname=name, material=name)


def _edges(from_: Points, to: Points, thickness: float) -> tuple[Points, Points, Points, Points]:
    """A line along the profile, within the ground."""
    inward = np.zeros_like(from_)
    rise = to[:, 1] - from_[:, 1]
    steep = to[:, 0] - from_[:, 0] < thickness * 1e-3
    inward[:, 1] = -thickness
    inward[steep] = np.stack([np.sign(rise[steep]) * thickness, np.zeros(steep.sum())], axis=1)
    # a face that rises is turned, so that it is seen from the same side
    return from_, to, from_ + inward, to + inward


def _level_lines(from_: Points, to: Points, leg_length: float) -> tuple[Points, Points, Points, Points]:
    """Level lines in the cut, as far as the ground reaches above them."""
    low = min(from_[:, 1].min(), to[:, 1].min()) - _DEPTH * leg_length
    high = max(from_[:, 1].max(), to[:, 1].max())
    pitch = 10.0 ** round(math.log10(_PITCH * leg_length))
    while (high - low) / pitch > _MOST_LINES:
        pitch *= 10.0
    starts, stops = [], []
    for level in pitch * np.arange(math.ceil(low / pitch), math.ceil(high / pitch)):
        before, after = from_[:, 1] - level, to[:, 1] - level
        seen = (before > 0.0) | (after > 0.0)
        share = np.divide(before, before - after, out=np.zeros_like(before), where=(before > 0.0) != (after > 0.0))
        crossing = from_[:, 0] + share * (to[:, 0] - from_[:, 0])
        left = np.where(before > 0.0, from_[:, 0], crossing)[seen]
        right = np.where(after > 0.0, to[:, 0], crossing)[seen]
        apart = left[1:] > right[:-1]  # else a line goes on in the next piece
        left, right = left[np.append(True, apart)[: len(left)]], right[np.append(apart, True)[-len(right) or 1 :]]
        starts.append(np.stack([left, np.full_like(left, level)], axis=1))
        stops.append(np.stack([right, np.full_like(right, level)], axis=1))
    left_ends, right_ends = np.concatenate(starts), np.concatenate(stops)
    down = np.array([0.0, _LINE * leg_length])
    return left_ends, right_ends, left_ends - down, right_ends - down
