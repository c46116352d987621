"""The ground as a surface, for pictures of robots in space: tiles whose perspective shows slopes along and across.

Tiles stand on a grid that belongs to the world. Edges between segments are grid lines, and a step has its own face.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from mjbiped.engines.mujoco.ground import Ground, Piece
from mjbiped.engines.mujoco.scenery import add_mesh
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.mujoco import mujoco

TILE = 0.25
"""Edge of a tile, in leg lengths, then rounded to a number of 1, 2 or 5 times a power of ten, m."""

_BEYOND = 12.0  # ground seen behind its beginning, where the first segment goes on without end, in leg lengths
_SIGHT, _ROOM = 26.0, 6.0  # ground before and behind the hip, and how far the hip goes on it, in leg lengths
_RIGHT, _LEFT = 7.0, 16.0  # ground on either side of y = 0, in leg lengths
_FINE, _NEAR = 4, 1.5  # parts of a tile's edge on rough ground, as far from y = 0, in leg lengths
_ROUGH = 5e-4  # height of rough ground over the straight lines between the corners of a tile, in leg lengths
_PROBES = 60  # places at which ground is asked whether it is rough
_EDGE, _ABOVE = 0.012, 1e-3  # width of the line along an edge between segments, and its height, in leg lengths
_BEFORE = 1e-9  # m: just before an edge
_SHADES = {"tile": (0.86, 0.855, 0.835, 1.0), "other_tile": (0.75, 0.745, 0.725, 1.0)}
"""Colours of tiles. What is not quite opaque casts no shadow, and shadows of far ground upon itself would be specks."""

Points = NDArray[np.float64]


def add_surface(
    spec: mujoco.MjSpec, ground: Ground, pieces: list[Piece], leg_length: float, x: float
) -> tuple[float, float]:
    """Add the ground as a surface in tiles; nothing can touch it.

    Args:
        spec: The scene, with a default class "scenery".
        ground: The terrain, cut into pieces.
        pieces: Those that are seen; the terrain's first segment goes on backwards.
        leg_length: Of the robot, m, which all that is seen follows.
        x: Of the hip, m, about which the ground is seen.

    Returns:
        Between which places of the hip (m) as much ground is seen; infinite where no more is known.
    """
    terrain, first, last = ground.terrain, pieces[0].segments[0], pieces[-1].segments[-1]
    start, stop = ground.starts[first] - (_BEYOND * leg_length if first == 0 else 0.0), ground.stops[last]
    stop += _BEYOND * leg_length if last == len(ground.stops) - 1 and math.isinf(terrain.end) else 0.0
    ends = [x + side * _SIGHT * leg_length for side in (-1.0, 1.0)]
    low = -math.inf if start >= ends[0] else x - _ROOM * leg_length
    high = math.inf if stop <= ends[1] else x + _ROOM * leg_length
    start, stop = max(start, ends[0]), min(stop, ends[1])
    _add_tiles(spec, terrain, start, stop, leg_length)
    return low, high


def _add_tiles(spec: mujoco.MjSpec, terrain: Terrain, start: float, stop: float, leg_length: float) -> None:
    """Add the tiles between two places (m), the faces of steps, and the lines along edges."""
    tile = tile_edge(leg_length)
    edges = np.array([edge for edge in terrain.x[1:] if start < edge < stop])
    parts = _FINE if _is_rough(terrain, start, stop, tile, leg_length) else 1
    x = np.union1d(tile / parts * np.arange(math.ceil(parts * start / tile), parts * stop / tile), [start, stop])
    x = np.sort(np.concatenate([x[~np.isin(x, edges)], edges - _BEFORE, edges]))
    near, rows = _NEAR * leg_length, np.arange(math.floor(-_RIGHT * leg_length / tile), _LEFT * leg_length / tile)
    fine = tile / parts * np.arange(-math.floor(near / tile) * parts, math.floor(near / tile) * parts + 1)
    y = np.union1d(tile * rows[np.abs(tile * rows) > near], fine)
    z = np.array([np.broadcast_to(terrain.across(place, y), y.shape) for place in x.tolist()])
    points = np.stack([*np.meshgrid(x, y, indexing="ij"), z], axis=-1)
    corners = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    middle = 0.5 * (corners[0] + corners[2])
    face = np.diff(x)[:, None] < 2.0 * _BEFORE
    odd = (np.floor(middle[..., 0] / tile) + np.floor(middle[..., 1] / tile)) % 2 == 1
    for name, colour in _SHADES.items():
        spec.add_material(name=name, rgba=colour, specular=0.0)
        add_mesh(spec, name, *(each[~face & (odd == (name == "other_tile"))] for each in corners))
    steps = face & (np.abs(corners[0] - corners[1])[..., 2] > _ROUGH * leg_length)
    if steps.any():
        spec.add_material(name="face", rgba=spec.material("earth").rgba.copy(), specular=0.0)
        add_mesh(spec, "face", *(np.concatenate(pair) for pair in _both_sides([each[steps] for each in corners])))
    if len(edges):
        wide, lift = _EDGE * leg_length * np.array([1.0, 0.0, 0.0]), _ABOVE * leg_length * np.array([0.0, 0.0, 1.0])
        lines = points[np.searchsorted(x, edges)] + lift
        right, left = lines[:, :-1].reshape(-1, 3), lines[:, 1:].reshape(-1, 3)
        add_mesh(spec, "profile_line", right, right + wide, left + wide, left)


def tile_edge(leg_length: float) -> float:
    """Edge of a tile, m."""
    power = 10.0 ** math.floor(math.log10(TILE * leg_length))
    return float(max(digit * power for digit in (1.0, 2.0, 5.0) if digit * power <= TILE * leg_length * 1.01))


def _is_rough(terrain: Terrain, start: float, stop: float, tile: float, leg_length: float) -> bool:
    """Whether heights within tiles of one segment leave the straight line between their corners."""
    across = (-0.5 * tile, 0.0, 0.5 * tile)
    for x in np.linspace(start, stop, _PROBES).tolist():
        before, between, after = (terrain.height_at(x, y) for y in across)
        if abs(0.5 * (before + after) - between) > _ROUGH * leg_length:
            return True
    return False


def _both_sides(corners: list[Points]) -> Iterator[tuple[Points, Points]]:
    """Corners of faces that are seen from either side."""
    yield from zip(corners, reversed(corners), strict=True)
