"""Heightfields of a scene, and surfaces as heightfields.

A surface is a heightfield of its own grid, with further ones around it, whose outer points have its edge's heights.

A foot's contact with a heightfield has the normal of the triangle under it. Only within the foot's radius of a line of
the grid, or of a diagonal, it touches the sides of MuJoCo's prisms as well: on bumps of 10 mm the normals of these
further contacts lean by up to 12 degrees from the triangle's at a depth of 1 um, by 36 at 10 um, and by 98 at 100 um,
where the foot's centre is under ground. Only MuJoCo's solver reads them, in some one of 150 steps on a grid of 5 cm.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.mujoco import mujoco

BESIDE = 3.0
"""Least width of the ground beyond a surface's grid, m."""

THICKNESS = 0.12  # of heightfield bases, m; contacts are never deeper than some 0.1 mm

Array: TypeAlias = NDArray[np.floating]
Pair: TypeAlias = tuple[float, float]


def add_geom(spec: mujoco.MjSpec, of: str, name: str, **given: object) -> None:
    """Add a geom of a default class, a box unless told otherwise."""
    spec.worldbody.add_geom(spec.find_default(of), name=name, **{"type": mujoco.mjtGeom.mjGEOM_BOX, **given})


def add_grid(spec: mujoco.MjSpec, name: str, heights: Array, middle: Pair, half: Pair) -> None:
    """Add a heightfield.

    Args:
        spec: The scene.
        name: Of the geom.
        heights: z at equidistant y (rows) and x (columns), m.
        middle: x and y of the grid's middle, m.
        half: Half its extent along x and y, m.
    """
    lowest = float(heights.min())
    rise = float(heights.max()) - lowest
    elevation = rise if rise > 0.0 else 1e-3  # MuJoCo stretches the data to 0..1, and refuses a zero scale
    rows, columns = heights.shape
    data = ((heights - lowest) / elevation).ravel()
    spec.add_hfield(name=name, size=[*half, elevation, THICKNESS], nrow=rows, ncol=columns, userdata=data)
    add_geom(spec, "terrain", name, type=mujoco.mjtGeom.mjGEOM_HFIELD, hfieldname=name, pos=[*middle, lowest])


def add_surface(spec: mujoco.MjSpec, name: str, terrain: Terrain, along: Pair, half_width: float, depth: float) -> None:
    """Add the ground of a terrain with a surface.

    Args:
        spec: The scene.
        name: Beginning of the geoms' names.
        terrain: The ground.
        along: Where it begins and ends at least, x in m.
        half_width: How far it reaches to either side at least, m.
        depth: Distance along the normal by which it lies lower, m.
    """
    surface = terrain.surface
    assert surface is not None
    rows, columns = surface.heights.shape
    x = _widened(surface.x0 + surface.spacing * np.arange(columns), along)
    y = _widened(surface.y0 + surface.spacing * np.arange(rows), (-half_width, half_width))
    fall = terrain.falls[0] if terrain.lateral else 0.0
    heights = np.pad(surface.heights, 1, mode="edge") - fall * y[:, None]
    heights += terrain.z[0] + terrain.gradients[0] * (x - terrain.x[0])
    heights -= depth * _lowering(np.diff(heights, axis=1) / np.diff(x), np.diff(heights, axis=0) / np.diff(y)[:, None])
    parts_y, parts_x = (list(pairwise((0, 1, count, count + 1))) for count in (rows, columns))
    for row, (right, left) in enumerate(parts_y):
        for column, (back, front) in enumerate(parts_x):
            part = heights[right : left + 1, back : front + 1]
            middle = float(x[back] + x[front]) / 2, float(y[right] + y[left]) / 2
            half = float(x[front] - x[back]) / 2, float(y[left] - y[right]) / 2
            add_grid(spec, f"{name}_{row}_{column}", part, middle, half)


def _widened(places: Array, reach: Pair) -> Array:
    """Places with one more on either side, m."""
    return np.array([min(reach[0], places[0] - BESIDE), *places, max(reach[1], places[-1] + BESIDE)])


def _lowering(along: Array, across: Array) -> Array:
    """Vertical distance, at a grid's corners, of a unit distance along the normals: the mean about each.

    Args:
        along: Gradients between the corners of a row.
        across: Those between the corners of a column.
    """
    triangles = along[:-1] ** 2 + across[:, 1:] ** 2, along[1:] ** 2 + across[:, :-1] ** 2
    cells = np.pad(np.sqrt(1.0 + np.array(triangles)).mean(axis=0), 1, mode="edge")
    between = (cells[:-1] + cells[1:]) / 2
    return np.asarray((between[:, :-1] + between[:, 1:]) / 2)
