"""Geoms that are added to a scene beside those of its model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np


def add_geom(
    scene: Any, geoms: Sequence[Any], kind: Any, size: Any, place: Any, frame: Any, rgba: tuple[float, ...]
) -> Any:
    """Add a geom that neither casts nor takes shadows to a scene; None where the scene is full.

    Args:
        scene: A `mujoco.MjvScene`.
        geoms: `scene.geoms`, which makes an object of each when it is asked for.
        kind: Of `mujoco.mjtGeom`.
        size: Three numbers, m.
        place: Its centre, m.
        frame: Its axes, nine numbers.
        rgba: Colour and opacity, each from 0 to 1.

    Returns:
        The geom; emission, specular and shininess are zero.
    """
    if scene.ngeom >= scene.maxgeom:
        return None
    geom = geoms[scene.ngeom]
    mujoco.mjv_initGeom(geom, kind, size, place, frame, np.array(rgba, dtype=np.float32))
    # mjv_initGeom leaves these as they are in memory, and pixels depend on them
    geom.category = mujoco.mjtCatBit.mjCAT_DECOR
    geom.objtype, geom.objid, geom.segid = mujoco.mjtObj.mjOBJ_UNKNOWN, -1, -1
    geom.emission, geom.specular, geom.shininess = 0.0, 0.0, 0.0
    scene.ngeom += 1
    return geom
