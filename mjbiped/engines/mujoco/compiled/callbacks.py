"""The callbacks as C functions, which Numba makes of the same source (`..callbacks`) and MuJoCo calls directly.

A compiled callback gets two addresses: of the mjModel and of the mjData. All that it works on, it finds from there:

* the walk's memory in `mjData.userdata`;
* what does not change (constants and gains) in a *record*, a block of numbers outside MuJoCo. The model's numeric field
  `scene.RECORDS` says where its records are while they are attached, `userdata[events.RECORD]` which one is meant. So
  one function serves any number of models, and one model many walks with gains of their own, in any thread.

A model without that field, with another's in it, or copied from one that has it (its own address stands there too) is
left alone, as is zeroed userdata.

Compilation leaves the order and the rounding of all operations as they are in Python, so both paths make
bitwise the same walk.
"""

from __future__ import annotations

import ctypes
import hashlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import mujoco
import numpy as np

from mjbiped.control.compilation import MachineCode
from mjbiped.engines.mujoco import callbacks, leapfrog
from mjbiped.engines.mujoco import contact_events as events
from mjbiped.engines.mujoco.callbacks import Laws, Recording, SimulationConstants
from mjbiped.engines.mujoco.compiled.layout import Layout, UnknownLayoutError, layout
from mjbiped.engines.mujoco.compiled.memory import memory_access
from mjbiped.engines.mujoco.options import ROOM
from mjbiped.engines.mujoco.scene import RECORDS_SIZE
from mjbiped.numerics.jit import c_function, described, options, prepared
from mjbiped.numerics.records import Packer, Shared
from mjbiped.rules.termination import Outcome

if TYPE_CHECKING:
    from mjbiped.control.controller import Law

_POSITION, _ACCELERATION = int(mujoco.mjtStage.mjSTAGE_POS), int(mujoco.mjtStage.mjSTAGE_ACC)


class Functions(NamedTuple):
    """C functions for MuJoCo, as ctypes function pointers; to be kept alive while they are installed.

    Attributes:
        mjcb_control: See `callbacks.control`.
        mjcb_sensor: See `callbacks.sense`.
        mjcb_contactfilter: See `callbacks.refuses`.
        token: Stands in the field `scene.RECORDS` of the models that they drive: the kind of their records.
    """

    mjcb_control: Any
    mjcb_sensor: Any
    mjcb_contactfilter: Any
    token: float


class Native:
    """Compiled callbacks and the record of one walk.

    Attributes:
        functions: Shared by all walks whose controllers have no more states than there is room for.
        constants: As given.
        made: Expression that makes the parts of the record in compiled code; see `numerics.records.Packer`.
        classes: The NamedTuples in it.
        record: Simulation constants and gains of this walk, and where its recording lies.
        recording: As given; its arrays are kept alive.
    """

    def __init__(self, law: Law, constants: SimulationConstants, recording: Recording) -> None:
        """Compile, or take from the cache, what this kind of walk needs.

        Args:
            law: The controller's.
            constants: The walk's.
            recording: To be written.

        Raises:
            UnknownLayoutError: This MuJoCo's structs are not understood.
            NotPackableError: The law's parameters cannot be put into a record.
            NumbaError: The laws cannot be compiled.
        """
        packed = constants._replace(places=callbacks.in_arrays(constants.places))
        shared = recording._replace(samples=Shared(recording.samples), rows=Shared(recording.rows))
        packer = Packer()
        self._law = law
        self._code = MachineCode(law, constants.states, constants.memory_size, contract=False, room=ROOM)
        self.made = packer.add((packed, shared, self._code.law))
        self.classes = tuple(packer.classes.items())
        self.functions = _compile(self.made, self.classes, layout())
        self.constants, self.recording = constants, recording
        self.record = packer.record()

    def with_constants(self, constants: SimulationConstants) -> Native:
        """The same walk in another scene."""
        return Native(self._law, constants, self.recording)

    def fits(self, model: mujoco.MjModel) -> bool:
        """Whether all places that the callbacks use are there in a model: C code does not look."""
        constants, places = self.constants, self.constants.places
        return bool(
            model.nuserdata >= events.CONTROLLER_MEMORY + constants.memory_size + constants.states
            and model.ngeom == len(places.risers)
            and model.nsensordata >= max(places.contacts) + places.slots
            and (model.nq, model.nv, model.nu) == (4, 4, 3)
            and model.nnumericdata >= RECORDS_SIZE
        )


@contextmanager
def attached(model: mujoco.MjModel, walks: Sequence[Native]) -> Iterator[None]:
    """Tell the compiled callbacks of a model's walks, and let them forget these afterwards.

    Args:
        model: Made by `scene.compose_scene`.
        walks: `userdata[events.RECORD]` is an index into them.

    Raises:
        ValueError: The walks are not all driven by the same functions, or not made for such a model; or one of several
            lands on its touchdowns, which changes the model's timestep.
    """
    functions = walks[0].functions
    if len(walks) > 1 and any(walk.constants.lands for walk in walks):
        raise ValueError("walks that land on their touchdowns need a model each")
    if not all(walk.functions is functions and walk.fits(model) for walk in walks):
        raise ValueError("walks of one model need the same machine code, and records made for a model like it")
    field = model.numeric_data[:RECORDS_SIZE]
    table = np.array([walk.record.ctypes.data for walk in walks], dtype=np.float64)  # addresses have 48 bits
    before = field.copy()
    field[:] = functions.token, model._address, table.ctypes.data, len(table)
    try:
        yield
    finally:
        field[:] = before


def check_offsets(data: mujoco.MjData) -> None:
    """Look whether what was found in other models holds for the very one that will be driven.

    Raises:
        UnknownLayoutError: It does not.
    """
    at = layout()
    for name in ("qpos", "qvel", "ctrl", "userdata", "sensordata", "geom_xpos", "qacc", "qfrc_applied"):
        found = ctypes.c_int64.from_address(data._address + getattr(at, name)).value
        if found != getattr(data, name).ctypes.data:
            raise UnknownLayoutError(f"MuJoCo {mujoco.__version__} keeps {name} elsewhere than in other models")


@lru_cache(maxsize=64)
def _compile(made: str, classes: tuple[tuple[str, type], ...], at: Layout) -> Functions:
    """The callbacks for one kind of record."""
    import numba

    from mjbiped.control import machine_code

    laws = Laws(machine_code.torque, machine_code.touchdown, machine_code.slope_estimate, machine_code.tick)
    own = (
        leapfrog.show,
        leapfrog.put_back,
        callbacks.control,
        callbacks.sense,
        callbacks.refuses,
        callbacks.softness,
    )
    groups = (Laws, callbacks.Setting, callbacks.Userdata, events.State)
    roots = (*own, *laws)
    known = (
        prepared(roots, inlined=(callbacks.control, laws.torque)),
        described(memory_access.__wrapped__),
        *(made, at, numba.__version__),
        *(events.CONTROLLER_MEMORY, events.RECORD, events.RUNNING, events.OUTCOME),
        *((kind.__qualname__, getattr(kind, "_fields", ())) for _, kind in classes),
    )
    digest = hashlib.sha256(repr(known).encode()).hexdigest()
    token = float(int(digest[:13], 16))  # 52 bits: exact
    name = digest[:16]
    source = f"""def bind(digest):
    def control_{name}(model, data):
        digest  # a cell that Numba's cache looks at
        record = record_of(model, data, TOKEN)
        if record != 0:
            p = numbers(record, SCALARS)
            constants, recording, parameters = {made}
            behind = MEMORY + constants.memory_size
            u = numbers(word(data + AT_USERDATA), behind + constants.states)
            put_back(u, numbers(word(data + AT_QVEL), 4))
            control(
                Setting(Laws(torque, touchdown, slope_estimate, tick), parameters, constants, recording),
                Userdata(u, u[MEMORY:behind], u[behind:]), numbers(word(data + AT_CTRL), 3),
                numbers(word(data + AT_QFRC_APPLIED), 4), numbers(data + AT_TIME, 1)[0],
                State(four(word(data + AT_QPOS)), four(word(data + AT_QVEL))),
            )
            failed = numbers(parameters.record, 1)  # see `MachineCode.failed`
            if failed[0] != 0.0:
                failed[0] = 0.0  # this step may be taken back and made again
                u[RUNNING] = 0.0
                u[OUTCOME] = INTERRUPTED

    def sensor_{name}(model, data, stage):
        digest
        record = record_of(model, data, TOKEN) if stage == ACCELERATION or stage == POSITION else 0
        if record != 0:
            p = numbers(record, SCALARS)
            constants, _, _ = {made}
            if stage == POSITION:
                show(
                    numbers(word(data + AT_USERDATA), MEMORY), constants, four(word(data + AT_QPOS)),
                    numbers(word(data + AT_QVEL), 4), numbers(data + AT_TIME, 1)[0],
                )
                return
            places = constants.places
            readings = numbers(word(data + AT_SENSORDATA), max(places.contacts[0], places.contacts[1]) + places.slots)
            length, weight = sense(
                constants, numbers(word(data + AT_USERDATA), MEMORY), readings, numbers(data + AT_TIME, 1)[0],
                State(four(word(data + AT_QPOS)), four(word(data + AT_QVEL))), four(word(data + AT_QACC)),
            )
            if length > 0.0:
                numbers(model + AT_TIMESTEP, 1)[0] = length
                if weight != 1.0:
                    accelerations = numbers(word(data + AT_QACC), 4)
                    for index in range(4):
                        accelerations[index] *= weight

    def filter_{name}(model, data, first, second):
        digest
        record = record_of(model, data, TOKEN)
        if record == 0:
            return 0
        p = numbers(record, SCALARS)
        constants, _, _ = {made}
        places = constants.places
        u = numbers(word(data + AT_USERDATA), MEMORY)
        minus_stiffness, minus_damping = softness(constants, u, numbers(data + AT_TIME, 1)[0])
        if minus_stiffness < 0.0:
            solref = array(word(model + AT_GEOM_SOLREF), (len(places.risers), 2))
            for foot in places.feet:
                solref[foot, 0], solref[foot, 1] = minus_stiffness, minus_damping
        centres = array(word(data + AT_GEOM_XPOS), (len(places.risers), 3))
        return 1 if refuses(constants, u, centres, first, second) else 0

    return control_{name}, sensor_{name}, filter_{name}
"""
    space: dict[str, Any] = {
        "__name__": __name__,
        **{part.__name__: part for part in (*own, *groups)},
        **laws._asdict(),
        "TOKEN": token,
        "SCALARS": made.count("p["),
        "MEMORY": events.CONTROLLER_MEMORY,
        "RUNNING": events.RUNNING,
        "OUTCOME": events.OUTCOME,
        "INTERRUPTED": float(Outcome.INTERRUPTED),
        "POSITION": _POSITION,
        "ACCELERATION": _ACCELERATION,
        **{f"AT_{key.upper()}": offset for key, offset in at._asdict().items()},
        **dict(classes),
        **memory_access(at),
    }
    exec(compile(source, "<compiled callbacks>", "exec"), space)
    word = numba.types.int64
    whole = numba.types.int32
    signatures = (
        numba.types.void(word, word),
        numba.types.void(word, word, whole),
        whole(word, word, whole, whole),
    )
    control, sensor, contact_filter = map(_cfunc, signatures, space["bind"](digest))
    return Functions(control, sensor, contact_filter, token)


def _cfunc(signature: Any, function: Callable[..., Any]) -> Any:

    compiled = c_function(function, signature, **options(contract=False))  # as Python rounds
    _kept.append(compiled)
    return compiled.ctypes


_kept: list[Any] = []  # their machine code lives as long as they do
