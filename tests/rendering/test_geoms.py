"""Geoms that are added to a scene."""

import mujoco
import numpy as np

from mjbiped.rendering.marks import Pen

MODEL = "<mujoco><worldbody><geom size='1'/></worldbody></mujoco>"
FIELDS = ("category", "objtype", "objid", "segid", "emission", "specular", "shininess", "reflectance", "modelrbound")


def test_nothing_of_a_geom_comes_from_what_was_in_its_memory() -> None:
    scene = mujoco.MjvScene(mujoco.MjModel.from_xml_string(MODEL), maxgeom=2)
    geoms = scene.geoms
    for geom, value in zip(geoms, (3, 5), strict=True):
        for name in FIELDS:
            setattr(geom, name, value)
    box, sphere = mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_SPHERE
    for kind in (box, sphere):
        Pen(scene, 1.0).add(kind, np.ones(3), np.zeros(3), np.eye(3).ravel(), (1.0, 0.5, 0.0, 1.0))
    one, other = geoms
    assert [getattr(one, name) for name in FIELDS] == [getattr(other, name) for name in FIELDS]
    assert (scene.ngeom, one.type, other.type) == (2, box, sphere)
    assert Pen(scene, 1.0).add(box, np.ones(3), np.zeros(3), np.eye(3).ravel(), (1.0, 0.5, 0.0, 1.0)) is None
