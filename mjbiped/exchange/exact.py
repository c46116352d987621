"""Exact numbers in the XML of a MuJoCo model, whose writer rounds to six digits."""

from __future__ import annotations

import math
from functools import partial
from xml.etree import ElementTree

import numpy as np

from mjbiped.exchange.links import joined
from mjbiped.utils.mujoco import mujoco

_ATTRIBUTES = {
    "body": {"pos": "pos", "quat": "quat"},
    "inertial": {"pos": "ipos", "mass": "mass", "diaginertia": "inertia"},
    "geom": {"pos": "pos", "quat": "quat", "size": "size", "friction": "friction", "solref": "solref"},
    "joint": {"pos": "pos", "ref": "qpos0", "range": "range"},
    "hfield": {"size": "size", "elevation": "data"},
    "key": {"qpos": "qpos", "qvel": "qvel"},
}
"""Attributes of elements whose numbers are written exactly, with their names in the compiled model."""

_close = partial(math.isclose, rel_tol=1e-5, abs_tol=1e-12)  # a number and its first six digits


def exact_xml(spec: mujoco.MjSpec, model: mujoco.MjModel) -> ElementTree.Element:
    """Write a model as XML, with the exact numbers of all that moves or touches.

    Args:
        spec: The specification; all that matters in it has a name.
        model: The model that it compiles to.
    """
    root = ElementTree.fromstring(spec.to_xml())
    for section in ("asset", "worldbody", "keyframe"):
        for parent in root.iter(section):
            for element in parent.iter():
                name = element.get("name")
                if element.tag in _ATTRIBUTES and name is not None:
                    _write(element, getattr(model, element.tag)(name))
                for inertial in element.findall("inertial"):
                    _write(inertial, model.body(name))
    option = root.find("option")
    if option is not None:
        option.set("timestep", repr(float(model.opt.timestep)))
        option.set("gravity", joined(model.opt.gravity))
    return root


def _write(element: ElementTree.Element, compiled: object) -> None:
    """Write the numbers of an element of the compiled model over their first six digits."""
    for name, field in _ATTRIBUTES[element.tag].items():
        written = element.get(name)
        if written is None:
            continue
        rounded = [float(number) for number in written.split()]
        exact = np.ravel(getattr(compiled, field))[: len(rounded)].tolist()
        # not by NumPy, whose `allclose` takes half of the time of a whole export
        if len(exact) == len(rounded) and all(map(_close, exact, rounded)):
            element.set(name, joined(exact))
