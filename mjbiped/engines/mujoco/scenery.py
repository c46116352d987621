"""Drawn parts of a scene without physics: the ground cut open along the robot's path, and arcs.

Seen from the side, the cut shows the ground in profile: filled, with a dark edge, and with thin level lines, which make
a slope of a degree visible.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mjbiped.engines.mujoco.ground import Ground, Piece
from mjbiped.robots.shape import ARC
from mjbiped.utils.mujoco import mujoco

CUT = 0.075
"""How far before the robot's plane the ground is cut, in leg lengths: just before its legs and feet."""

_BACK = 9.0  # of the ground behind the robot's plane, in leg lengths; there it has the sky's colour
_DEPTH = 2.0  # of the cut, in leg lengths
_BEYOND = 8.0  # ground seen behind its beginning, where the first segment goes on without end, in leg lengths
_EDGE = 0.011  # thickness of the profile's line, in leg lengths: four pixels
_LINE = 0.004  # thickness of a level line, in leg lengths: more than a pixel, or it would come and go
_PITCH = 0.1  # between level lines, in leg lengths, then rounded to a power of ten in m
_MOST_LINES = 300
_STRIPE, _STRIPES = 0.006, 0.5  # width of the stripes across the ground, and the distance between them, in leg lengths
_SHADES, _MOST_FACES = 10, 5000  # plain shades that make a gradient, and faces of all of them: rough ground has fewer
_OVERLAP = 1e-5  # of neighbouring shades, a share of the way, or specks of sky would shine between them
_BEFORE = 5e-4  # of line before cut, edge before line, and stripes over ground, in leg lengths: no faces in one plane

Points = NDArray[np.float64]


def add_section(spec: mujoco.MjSpec, ground: Ground, pieces: list[Piece], leg_length: float) -> None:
    """Add the ground as it is seen from the side; nothing can touch it.

    Args:
        spec: The scene, with a default class "scenery".
        ground: The terrain, cut into pieces.
        pieces: Those that are seen; the terrain's first segment goes on backwards.
        leg_length: Of the robot, m, which all that is seen follows.
    """
    points = np.array(ground.profile(pieces))
    if pieces[0].segments.start == 0:
        fall = (points[1] - points[0]) / (points[1, 0] - points[0, 0])
        points = np.vstack([points[0] - _BEYOND * leg_length * fall, points])
    from_, to = points[:-1], points[1:]
    down, cut, before = np.array([0.0, _DEPTH * leg_length]), -CUT * leg_length, _BEFORE * leg_length
    shades = max(4, min(_SHADES, _MOST_FACES // len(from_)))
    for name, begin, end in _shades(spec, "earth", "depth", shades):
        _add_cut(spec, name, cut, *(points - share * down for share in (begin, end) for points in (from_, to)))
    _add_cut(spec, "level_line", cut - before, *_level_lines(from_, to, leg_length))
    _add_cut(spec, "profile_line", cut - 2.0 * before, *_edges(from_, to, _EDGE * leg_length))
    for name, begin, end in _shades(spec, "surface", "distance", shades):
        _add_floor(spec, name, from_, to, leg_length, (begin, end))
    pitch = _STRIPES * leg_length
    starts = pitch * np.arange(math.ceil(points[0, 0] / pitch), math.floor(points[-1, 0] / pitch))
    edges = (starts, starts + _STRIPE * leg_length)
    left, right = (np.stack([x, np.interp(x, *points.T) + before], axis=1) for x in edges)
    _add_floor(spec, "stripe", left, right, leg_length)


def _add_cut(
    spec: mujoco.MjSpec, name: str, y: float, left: Points, right: Points, low_left: Points, low_right: Points
) -> None:
    """Add faces in the plane at y by their corners (x, z)."""
    add_mesh(spec, name, *(_at(y, each) for each in (right, left, low_left, low_right)))


def _add_floor(
    spec: mujoco.MjSpec, name: str, from_: Points, to: Points, leg_length: float, part: tuple[float, float] = (0.0, 1.0)
) -> None:
    """Add faces from the cut backwards, or a part of them between two shares of the way."""
    near, far = (leg_length * (share * (_BACK + CUT) - CUT) for share in part)
    add_mesh(spec, name, _at(near, from_), _at(near, to), _at(far, to), _at(far, from_))


def _shades(spec: mujoco.MjSpec, first: str, last: str, count: int) -> Iterator[tuple[str, float, float]]:
    """Make plain materials from one material's colour to another's: a textured pixel takes software twice as long.

    Yields:
        Name of a material, and the shares of the way at which its band begins and ends; there is a little overlap.
    """
    colour, change = spec.material(first).rgba.copy(), spec.material(last).rgba - spec.material(first).rgba
    shares = np.linspace(0.0, 1.0, count + 1)
    edges = (0.5 - np.sin(np.arcsin(1.0 - 2.0 * shares) / 3.0)).tolist()  # even steps of a smooth S
    for number, (begin, end) in enumerate(pairwise(edges)):
        name = f"{first}_{number}" if number else first
        material = spec.add_material(name=name) if number else spec.material(first)
        material.rgba, material.specular = colour + (number + 0.5) / count * change, 0.0
        yield name, begin, end + _OVERLAP


def _at(y: float, points: Points) -> Points:
    """Points of the plane at y."""
    return np.insert(points, 1, y, axis=1)


def add_mesh(spec: mujoco.MjSpec, name: str, *corners: Points) -> None:
    """Add four-cornered faces: the first corners of all, their second ones, and so on, counterclockwise.

    The mesh has the material of its name; a texture runs from its middle at the first two corners to its end.
    """
    count = len(corners[0])
    a, b, c, d = (np.arange(count) + k * count for k in range(4))
    spec.add_mesh(
        name=name,
        uservert=np.concatenate(corners).ravel(),
        usertexcoord=np.repeat([(0.5, 0.5), (0.5, 0.99)], 2 * count, axis=0).ravel(),
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


def add_arc(tip: mujoco.MjsGeom, radius: float, turn: float, centre: list[float]) -> None:
    """Add what is seen of a round foot: its arc, of capsules that touch the ground from above.

    Args:
        tip: What is seen of the end of its leg.
        radius: Of the foot, m.
        turn: Angle of the leg's last segment where its joints are at zero, rad.
        centre: Of the arc, m.
    """
    thick, bends = 0.5 * float(tip.size[0]), np.linspace(-ARC, ARC, 13) - turn
    points = (radius - thick) * np.stack([np.sin(bends), np.zeros_like(bends), -np.cos(bends)], axis=-1) + centre
    for number, (start, end) in enumerate(pairwise(points)):
        name = f"{tip.name.removesuffix('_tip')}_arc_{number}"
        arc = tip.parent.add_geom(tip.classname, name=name, type=mujoco.mjtGeom.mjGEOM_CAPSULE)
        arc.size[0], arc.fromto, arc.material = thick, [*start, *end], tip.material
    tip.size *= 0.5
