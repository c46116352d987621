"""Where MuJoCo keeps its numbers: offsets in the C structs `mjModel` and `mjData`, found by looking.

The Python bindings tell the addresses of the arrays, and the structs hold these addresses. So each struct of two
different models is searched for them; an offset counts if it is the only one in both. Nothing of MuJoCo's headers is
assumed but what `_SHARED` says, and a MuJoCo that keeps its numbers elsewhere is either understood or refused.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjbiped.errors import MjbipedError
from mjbiped.numerics.records import WORD
from mjbiped.utils.mujoco import mujoco

_SHARED = ("qpos", "ctrl")
"""Two pointers always agree with these: the buffer begins with qpos, and the states of plugins, which no model here
has, come just before ctrl. An empty array has the address of the next one, and the pointers stand in the order of the
arrays: the later of the two is meant, and while no plugin is there they are the same."""

_LARGEST = 1 << 24  # a struct beyond it is none, bytes


class UnknownLayoutError(MjbipedError):
    """The structs of this MuJoCo, or on this system, are not as expected; compiled callbacks cannot be used."""


class Layout(NamedTuple):
    """Offsets in bytes, in multiples of `WORD`.

    Attributes:
        timestep: In mjModel: the number `opt.timestep`.
        numerics: In mjModel: number of floats in `numeric_data`.
        numeric_data: In mjModel: pointer, as all that follow up to `eq_data`.
        geom_solref: See MuJoCo's documentation for this and all that follow.
        jnt_solref: See there.
        eq_solref: See there.
        eq_data: See there.
        time: In mjData: the number `time`.
        qpos: In mjData: pointer, as all that follow.
        qvel: See there.
        ctrl: See there.
        userdata: See there.
        sensordata: See there.
        geom_xpos: See there.
        qacc: See there.
        qfrc_applied: See there.
        eq_active: See there.
    """

    timestep: int
    numerics: int
    numeric_data: int
    geom_solref: int
    jnt_solref: int
    eq_solref: int
    eq_data: int
    time: int
    qpos: int
    qvel: int
    ctrl: int
    userdata: int
    sensordata: int
    geom_xpos: int
    qacc: int
    qfrc_applied: int
    eq_active: int


@lru_cache(maxsize=1)
def layout() -> Layout:
    """The offsets for the MuJoCo that is loaded, searched for at the first call.

    Raises:
        UnknownLayoutError: They cannot be found.
    """
    if np.dtype(np.intp).itemsize != WORD or np.dtype(np.float64).itemsize != WORD:
        raise UnknownLayoutError("compiled callbacks need a system of 64 bits")
    specimens = [_specimen(joints=2, numerics=7919, timestep=1.2345e-4), _specimen(3, 6997, 2.3456e-4)]
    found: dict[str, int] = {}
    for struct in (0, 1):
        structs = [_words(pair[struct]) for pair in specimens]
        sought = [(_model_marks, _data_marks)[struct](pair[struct]) for pair in specimens]
        for name in sought[0]:
            found[name] = _only_place(name, structs, [marks[name] for marks in sought])
    return Layout(**found)


@lru_cache(maxsize=1)
def library() -> ctypes.CDLL:
    """MuJoCo's own library, the one that its Python bindings have loaded.

    Raises:
        UnknownLayoutError: It is not where it is expected.
    """
    for path in sorted(Path(mujoco.__file__).parent.glob("libmujoco*")):
        try:
            return ctypes.CDLL(str(path))
        except OSError:
            continue
    raise UnknownLayoutError(f"MuJoCo {mujoco.__version__} does not have its library beside its Python package")


def _specimen(joints: int, numerics: int, timestep: float) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """A model and its data, of sizes and numbers that occur only once."""
    spec = mujoco.MjSpec()
    spec.option.timestep = timestep
    spec.nuserdata = 11 * joints
    spec.add_numeric(name="numbers", size=numerics, data=[0.0] * numerics)
    body = spec.worldbody
    for index in range(joints):
        body = body.add_body(name=f"body{index}")
        body.add_joint(name=f"joint{index}", type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 1, 0])
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.1, 0, 0], pos=[1.0, 0, 0])
        actuator = spec.add_actuator(name=f"motor{index}", target=f"joint{index}")
        actuator.trntype = mujoco.mjtTrn.mjTRN_JOINT
        actuator.dyntype = mujoco.mjtDyn.mjDYN_INTEGRATOR  # else `act` and `act_dot` are empty
        spec.add_sensor(
            name=f"sensor{index}",
            type=mujoco.mjtSensor.mjSENS_JOINTPOS,
            objtype=mujoco.mjtObj.mjOBJ_JOINT,
            objname=f"joint{index}",
        )
    spec.worldbody.add_body(name="marker", mocap=True)  # else what stands before `qacc` is empty
    spec.add_equality(name="lock", type=mujoco.mjtEq.mjEQ_JOINT, name1="joint0")
    model = spec.compile()
    data = mujoco.MjData(model)
    data.time = 3.0e5 * timestep
    return model, data


def _model_marks(model: mujoco.MjModel) -> dict[str, int]:
    """What stands in mjModel, as 64-bit words."""
    arrays = ("numeric_data", "geom_solref", "jnt_solref", "eq_solref", "eq_data")
    sizes = {"timestep": _bits(model.opt.timestep), "numerics": int(model.nnumericdata)}
    return {**sizes, **{name: _address(getattr(model, name)) for name in arrays}}


def _data_marks(data: mujoco.MjData) -> dict[str, int]:
    """What stands in mjData, as 64-bit words."""
    arrays = ("qpos", "qvel", "ctrl", "userdata", "sensordata", "geom_xpos", "qacc", "qfrc_applied", "eq_active")
    return {"time": _bits(data.time), **{name: _address(getattr(data, name)) for name in arrays}}


def _bits(number: float) -> int:
    return int(np.float64(number).view(np.int64))


def _address(array: NDArray[Any]) -> int:
    return int(array.ctypes.data)


def _words(owner: Any) -> NDArray[np.int64]:
    """A copy of the struct behind a model or its data.

    Raises:
        UnknownLayoutError: Its address or its size cannot be known.
    """
    address = getattr(owner, "_address", None)
    size = _allocated(address) if isinstance(address, int) else 0
    if not isinstance(address, int) or not WORD <= size <= _LARGEST:
        raise UnknownLayoutError(f"MuJoCo's {type(owner).__name__} cannot be looked into on this system")
    return np.frombuffer(ctypes.string_at(address, size - size % WORD), dtype=np.int64)


def _allocated(address: int) -> int:
    """Size of a piece of allocated memory, bytes; 0 where the C library does not tell."""
    try:
        library = ctypes.CDLL(None)
    except (OSError, TypeError):  # Windows
        return 0
    for name in ("malloc_usable_size", "malloc_size"):  # Linux, macOS
        ask = getattr(library, name, None)
        if ask is not None:
            ask.argtypes, ask.restype = [ctypes.c_void_p], ctypes.c_size_t
            return int(ask(address))
    return 0


def _only_place(name: str, structs: Sequence[NDArray[np.int64]], marks: Sequence[int]) -> int:
    """The offset at which every struct has its mark, in bytes.

    Raises:
        UnknownLayoutError: There is none, or more than one.
    """
    places = [set(np.flatnonzero(words == mark).tolist()) for words, mark in zip(structs, marks, strict=True)]
    common = set.intersection(*places)
    if not 1 <= len(common) <= 1 + (name in _SHARED):
        raise UnknownLayoutError(
            f"MuJoCo {mujoco.__version__} keeps {name} in {len(common)} places that look alike; expected one"
        )
    return WORD * max(common)
