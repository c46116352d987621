"""The callbacks as C functions, which Numba makes of the same source as Python's and MuJoCo calls directly.

A compiled callback gets two addresses: of the mjModel and of the mjData. All that it works on, it finds from there:

* the walk's state and the controller's memory in `mjData.userdata`;
* what does not change (constants and gains) in a *record*, a block of numbers outside MuJoCo. The model's numeric field
  `scene.RECORDS` says where its records are while they are attached, `State.record` which one is meant. So one function
  serves any number of models, and one model many walks with gains of their own, in any thread.

MuJoCo has one place for each callback, and robots and laws need machine code of their own. So what stands there
(`trampolines`) only looks into the model's field for the address of the function that it is to call. A model without
that field, with another's in it, or copied from one that has it (its own address stands there too) is left alone, as is
zeroed userdata.

Compilation leaves the order and the rounding of all operations as they are in Python, so both paths make
bitwise the same walk.
"""

from __future__ import annotations

import ctypes
import hashlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache, partial
from typing import Any, NamedTuple

import numpy as np

from mjbiped.control.compiled import CalledMethods, MachineCode
from mjbiped.engines.mujoco import contacts, leapfrog, motors, state, step_size
from mjbiped.engines.mujoco.compiled.layout import Layout, UnknownLayoutError, layout
from mjbiped.engines.mujoco.motors import Parts, Recording
from mjbiped.engines.mujoco.scene import ARRIVE, CONTROL, FILTER, RECORDS_SIZE, SENSOR
from mjbiped.engines.mujoco.state import SIZE, Constants, State
from mjbiped.numerics.jit import OPTIONS, c_function, described, from_source, jitted, prepared
from mjbiped.numerics.records import WORD, Packer, Shared
from mjbiped.records.pressure import note_pressure
from mjbiped.records.rows import Rows
from mjbiped.robots.bent_leg import bent_leg
from mjbiped.rules.scuffing import swing_foot_collides, swing_foot_is_drawn_in
from mjbiped.rules.termination import Outcome
from mjbiped.terrain import profile
from mjbiped.utils.mujoco import mujoco

POSITION, ACCELERATION = int(mujoco.mjtStage.mjSTAGE_POS), int(mujoco.mjtStage.mjSTAGE_ACC)


class Functions(NamedTuple):
    """C functions for MuJoCo, as ctypes function pointers; to be kept alive while they are installed.

    Attributes:
        arrive: Called by the others, see `motors.arrive`; None of `trampolines`.
        mjcb_control: MuJoCo's callback, as those that follow.
        mjcb_sensor: See MuJoCo.
        mjcb_contactfilter: See MuJoCo.
    """

    arrive: Any
    mjcb_control: Any
    mjcb_sensor: Any
    mjcb_contactfilter: Any


class Native:
    """Compiled callbacks and the record of one walk.

    Attributes:
        functions: Shared by all walks of a kind of robot whose controllers have no more states than there is room for.
        code: As given, as `constants`, `rows` and `recording` are.
        constants: The walk's.
        made: Expression that makes the parts of the record in compiled code; see `numerics.records.Packer`.
        classes: The NamedTuples in it.
        record: Constants and gains of this walk, and where its recording lies.
        rows: How rows of this kind of robot are written.
        recording: As given; its arrays are kept alive.
    """

    def __init__(
        self, code: MachineCode | CalledMethods, constants: Constants, rows: Rows, recording: Recording
    ) -> None:
        """Compile, or take from the cache, what this kind of walk needs.

        Args:
            code: Addresses of the controller's laws.
            constants: The walk's.
            rows: How rows of this kind of robot are written.
            recording: To be written.

        Raises:
            UnknownLayoutError: This MuJoCo's structs are not understood.
        """
        packed = constants._replace(places=state.in_arrays(constants.places))
        shared = recording._replace(samples=Shared(recording.samples), rows=Shared(recording.rows))
        packer = Packer()
        self.made = packer.add((packed, shared, code.law))
        self.classes = tuple(packer.classes.items())
        self.functions = _compile(self.made, self.classes, rows, layout())
        self.code, self.constants, self.rows, self.recording = code, constants, rows, recording
        self.record = packer.record()

    def with_constants(self, constants: Constants) -> Native:
        """The same walk in another scene."""
        return Native(self.code, constants, self.rows, self.recording)

    def fits(self, model: mujoco.MjModel) -> bool:
        """Whether all places that the callbacks use are there in a model: C code does not look."""
        constants, places = self.constants, self.constants.places
        n = len(places.order)
        return bool(
            model.nuserdata >= SIZE + constants.touched + constants.memory_size + constants.states
            and model.ngeom == len(places.risers)
            and model.nsensordata >= max(leg.contacts for leg in places.legs) + places.slots
            and (model.nq, model.nv, model.nu) == (n, n, places.actuators)
            and model.nnumericdata >= RECORDS_SIZE
        )


@contextmanager
def attached(model: mujoco.MjModel, walks: Sequence[Native]) -> Iterator[None]:
    """Tell the compiled callbacks of a model's walks, and let them forget these afterwards.

    Args:
        model: Made by `scene.compose_scene`.
        walks: `State.record` is an index into them.

    Raises:
        ValueError: The walks are not all driven by the same functions, or not made for such a model; or one of several
            lands on its impacts, which changes the model's timestep.
    """
    functions = walks[0].functions
    if len(walks) > 1 and any(walk.constants.lands for walk in walks):
        raise ValueError("walks that land on their touchdowns need a model each")
    if not all(walk.functions is functions and walk.fits(model) for walk in walks):
        raise ValueError("walks of one model need the same machine code, and records made for a model like it")
    field = model.numeric_data[:RECORDS_SIZE]
    table = np.array([walk.record.ctypes.data for walk in walks], dtype=np.float64)  # addresses have 48 bits
    before = field.copy()
    field[:] = *map(address_of, functions), model._address, table.ctypes.data, len(table)
    try:
        yield
    finally:
        field[:] = before


def address_of(function: Any) -> int:
    """Address of a C function, of its pointer in ctypes."""
    return ctypes.cast(function, ctypes.c_void_p).value or 0


def check_offsets(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Look whether what was found in other models holds for the very one that will be driven.

    Raises:
        UnknownLayoutError: It does not.
    """
    at = layout()
    names = [name for name in Layout._fields if name not in ("timestep", "numerics", "time")]
    for name in names:
        owner = model if hasattr(model, name) else data
        array = getattr(owner, name)
        found = ctypes.c_int64.from_address(owner._address + getattr(at, name)).value
        if array.size and found != array.ctypes.data:
            raise UnknownLayoutError(f"MuJoCo {mujoco.__version__} keeps {name} elsewhere than in other models")


_SOURCE = """def bind(digest):
    def arrive_{name}(model, data):
        digest  # a cell that Numba's cache looks at
        record = record_of(model, data)
        p = numbers(record, SCALARS)
        constants, recording, parameters = {made}
        n = len(constants.places.order)
        qpos, qvel = numbers(word(data + AT_QPOS), n), numbers(word(data + AT_QVEL), n)
        setting = Setting(Parts({parts}), parameters, constants, recording)
        arrive(setting, {userdata}, numbers(data + AT_TIME, 1)[0], qpos, qvel)

    def control_{name}(model, data):
        digest
        record = record_of(model, data)
        if record == 0:
            return
        call_with({arrive}, model, data)
        p = numbers(record, SCALARS)
        constants, recording, parameters = {made}
        setting, userdata = Setting(Parts({parts}), parameters, constants, recording), {userdata}
        ctrl = numbers(word(data + AT_CTRL), constants.places.actuators)
        applied = numbers(word(data + AT_QFRC_APPLIED), len(constants.places.order))
        control(setting, userdata, ctrl, applied, numbers(data + AT_TIME, 1)[0])
        failed = numbers(parameters.record, 1)  # see `MachineCode.failed`
        if failed[0] != 0.0:
            failed[0] = 0.0  # this step may be taken back and made again
            userdata.u.running, userdata.u.outcome = 0.0, INTERRUPTED

    def sensor_{name}(model, data, stage):
        digest
        record = record_of(model, data) if stage == ACCELERATION or stage == POSITION else 0
        if record == 0:
            return
        p = numbers(record, SCALARS)
        constants, _, _ = {made}
        u, n = state_at(word(data + AT_USERDATA)), len(constants.places.order)
        if stage == POSITION:
            call_with({arrive}, model, data)
            show(constants, u, numbers(word(data + AT_QPOS), n), numbers(word(data + AT_QVEL), n))
            return
        readings = numbers(word(data + AT_SENSORDATA), constants.places.readings)
        qacc = numbers(word(data + AT_QACC), n)
        length = resolve(constants, u, readings, qacc, softness_at(model, data, constants))
        if length > 0.0:
            numbers(model + AT_TIMESTEP, 1)[0] = length

    def filter_{name}(model, data, first, second):
        digest
        record = record_of(model, data)
        u = state_at(word(data + AT_USERDATA))
        if record == 0 or not u.running:
            return 0
        if numbers(data + AT_TIME, 1)[0] > u.time or u.shown:
            call_with({arrive}, model, data)
        p = numbers(record, SCALARS)
        constants, _, _ = {made}
        soften(constants, u, softness_at(model, data, constants))
        centres = array(word(data + AT_GEOM_XPOS), (len(constants.places.risers), 3))
        return 1 if refuses(constants, u, centres, first, second) else 0

    return arrive_{name}, control_{name}, sensor_{name}, filter_{name}
"""

# in place: no function can return a state
_USERDATA = """Userdata(
                state_at(word(data + AT_USERDATA)),
                numbers(word(data + AT_USERDATA) + WORD * SIZE, constants.touched),
                numbers(word(data + AT_USERDATA) + WORD * (SIZE + constants.touched), constants.memory_size),
                numbers(
                    word(data + AT_USERDATA) + WORD * (SIZE + constants.touched + constants.memory_size),
                    constants.states,
                ),
            )"""

_ARRIVE = "int(numbers(field_of(model), FIELD)[ARRIVE])"  # compiled once, and called by its address

_TRAMPOLINES = """def bind(digest):
    def control_{name}(model, data):
        digest
        field = field_of(model)
        if field != 0:
            call_with(int(numbers(field, SIZE)[CONTROL]), model, data)

    def sensor_{name}(model, data, stage):
        digest
        field = field_of(model)
        if field != 0:
            call_sensor(int(numbers(field, SIZE)[SENSOR]), model, data, stage)

    def filter_{name}(model, data, first, second):
        digest
        field = field_of(model)
        if field == 0:
            return 0
        return call_filter(int(numbers(field, SIZE)[FILTER]), model, data, first, second)

    return control_{name}, sensor_{name}, filter_{name}
"""


_APART = (
    *(profile.height_of, profile.height_over, profile.height_over_ground),
    *(profile.segment_met, profile.segment_stood_on, profile.segment_under),
    *(swing_foot_collides, swing_foot_is_drawn_in, note_pressure, bent_leg),
)


@lru_cache(maxsize=64)
def _compile(made: str, classes: tuple[tuple[str, type], ...], rows: Rows, at: Layout) -> Functions:
    """The callbacks for one kind of record."""
    from mjbiped.control.machine_code import torque
    from mjbiped.engines.mujoco.compiled import memory
    from mjbiped.numerics.addresses import call_with

    parts, names = parts_of(rows)
    own = (motors.arrive, motors.control, leapfrog.show, step_size.resolve, step_size.soften, contacts.refuses)
    groups = (Parts, motors.Setting, state.Userdata)
    known = (
        # a call of a function that is not inlined copies all constants; those of other rooms take few of them
        prepared((*own, *parts.values()), inlined=(*own, torque), apart=_APART),
        described(memory.memory_access.__wrapped__),
        *(made, at, SIZE, State._fields_),
        *((kind.__qualname__, getattr(kind, "_fields", ())) for _, kind in classes),
    )
    space = {
        **{part.__name__: part for part in (*own, *groups)},
        **parts,
        "SCALARS": made.count("p["),
        "SIZE": SIZE,
        "FIELD": RECORDS_SIZE,
        "ARRIVE": ARRIVE,
        "call_with": call_with,
        "WORD": WORD,
        "INTERRUPTED": float(Outcome.INTERRUPTED),
        "POSITION": POSITION,
        "ACCELERATION": ACCELERATION,
        **dict(classes),
    }
    return _functions(
        _SOURCE, {"made": made, "parts": names, "userdata": _USERDATA, "arrive": _ARRIVE}, space, known, at
    )


def parts_of(rows: Rows) -> tuple[dict[str, Any], str]:
    """The functions of `motors.Parts` for compiled code, by the names that they have there, and these names."""
    from mjbiped.control import machine_code as laws
    from mjbiped.engines.mujoco.compiled import memory

    parts = (
        *(laws.torque, laws.touchdown, laws.slope_estimate, laws.tick, laws.knee_strike),
        *(memory.told, rows.write_sample, rows.write_touchdown),
    )
    named = {f"part_{index}": part for index, part in enumerate(parts)}
    return named, ", ".join(named)


@lru_cache(maxsize=1)
def trampolines() -> Functions:
    """The callbacks that stand in MuJoCo's places, whatever robots and laws are walking.

    Raises:
        UnknownLayoutError: This MuJoCo's structs are not understood.
    """
    from mjbiped.engines.mujoco.compiled import memory
    from mjbiped.numerics.addresses import call_with

    space = {"call_with": call_with, "call_sensor": memory.call_sensor, "call_filter": memory.call_filter}
    space = {**space, "SIZE": RECORDS_SIZE, "CONTROL": CONTROL, "SENSOR": SENSOR, "FILTER": FILTER}
    return _functions(_TRAMPOLINES, {}, space, (described(memory.memory_access.__wrapped__), layout()), layout())


_EXCHANGE = """def exchange(places, clock):
    warning, kept = word(places + WORD * (COUNT - 1)), places + WORD * (2 * COUNT + 1)
    if clock < 0:
        for k in range(COUNT - 1):
            if word(word(places + WORD * k)) != 0:
                return -1
        put_word(kept, word(warning))
        at = word(places + WORD * COUNT)
        clock = word(at)
        for k in range(COUNT):
            put_word(word(places + WORD * k), word(places + WORD * (COUNT + 1 + k)))
        put_word(at, 0)
        return clock
    for k in range(COUNT - 1):
        put_word(word(places + WORD * k), 0)
    put_word(warning, word(kept))
    put_word(word(places + WORD * COUNT), clock)
    return 0
"""


@lru_cache(maxsize=1)
def exchanging(count: int) -> Callable[[int, int], int]:
    """Compile the function that fills and empties MuJoCo's places, for it is done before and after each short advance.

    Args:
        count: Number of places, that of warnings the last, beside the clock's.

    Returns:
        A function of two integers. The first is the address of these: the places' addresses, the clock's, what the
        places shall hold, and room for what the place of warnings held, which dm_control fills. Where the second is
        negative and the other places are empty, it fills them, empties the clock's and returns what that held; where
        they are not empty, it returns -1. Where the second is the clock, all is undone.
    """
    from mjbiped.numerics.addresses import put_word, word

    made = partial(jitted, _nrt=False)
    space = {"word": word, "put_word": put_word, "COUNT": count, "WORD": WORD, "__name__": __name__}
    exchange: Callable[[int, int], int] = from_source(made, "exchange", _EXCHANGE, space, count)
    return exchange


def _functions(source: str, words: dict[str, str], space: dict[str, Any], known: Any, at: Layout) -> Functions:
    """Compile the three callbacks of a text, kept on disk under what is known of them."""
    import numba

    from mjbiped.engines.mujoco.compiled import memory

    digest = hashlib.sha256(repr((source, known, OPTIONS, numba.__version__)).encode()).hexdigest()
    given: dict[str, Any] = {
        "__name__": __name__,
        **space,
        **{f"AT_{key.upper()}": offset for key, offset in at._asdict().items()},
        **memory.memory_access(at),
    }
    exec(compile(source.format(name=digest[:16], **words), "<compiled callbacks>", "exec"), given)
    word, whole = numba.types.int64, numba.types.int32
    arrive = control = numba.types.void(word, word)
    signatures = (arrive, control, numba.types.void(word, word, whole), whole(word, word, whole, whole))
    functions = given["bind"](digest)
    made = [
        c_function(function, signature, **OPTIONS)
        for function, signature in zip(functions, signatures[-len(functions) :], strict=True)
    ]
    _kept.extend(made)
    return Functions(*[None] * (4 - len(made)), *(each.ctypes for each in made))


_kept: list[Any] = []  # their machine code lives as long as they do
