"""Compiled callbacks: the same walks as with Python's, and nothing else is touched."""

import copy
import math
import threading
import warnings
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import pytest
from simulations import make_simulation

import mjbiped
from controllers import AdaptiveController, Controller, Memory, PassiveController
from mjbiped.control.compiled import LawError
from mjbiped.control.controller import Law
from mjbiped.engines.mujoco import simulation as physics
from mjbiped.engines.mujoco.compiled.callbacks import attached
from mjbiped.engines.mujoco.compiled.layout import UnknownLayoutError
from mjbiped.engines.mujoco.run import simulate
from mjbiped.engines.mujoco.scene import COUNT, RECORDS
from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.engines.mujoco.state import State
from mjbiped.numerics.jit import raises
from mjbiped.numerics.records import NotPackableError, Packer
from mjbiped.records.recorder import Recorder
from mjbiped.rules.termination import Outcome

pytestmark = pytest.mark.compiled

Terrain = mjbiped.Terrain
STATE = mujoco.mjtState.mjSTATE_INTEGRATION


def nine_rates(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> None:
    for index in range(11):
        out[index] = 0.0


class NineStates(PassiveController):
    """More states than the machine code of the other controllers has room for: it needs one of its own."""

    states = tuple(f"state_{index}" for index in range(9))
    memory_size = 9

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        return (0.0,) * 11

    def law(self) -> Law:
        return super().law()._replace(torque=nine_rates)


def make(controller: Controller, terrain: Terrain | None = None, **parameters: object) -> Simulation:
    robot = controller.robot or mjbiped.Compass()
    start = controller.gait.start.tolist() if controller.gait else [0.0, 0.0, 0.0, 0.0]
    arguments: dict[str, Any] = {"robot": robot, "q": start[:2], "dq": start[2:], "steps": 60, "timestep": 5e-4}
    return make_simulation(controller, terrain or Terrain.mixed(), **{**arguments, **parameters})


def state_of(model: mujoco.MjModel, data: mujoco.MjData) -> bytes:
    state = np.zeros(mujoco.mj_stateSize(model, STATE))
    mujoco.mj_getState(model, data, state, STATE)
    return state.tobytes()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("terrain", "parameters"),
    [
        pytest.param(Terrain.level(), {}, marks=pytest.mark.slow),
        (Terrain.mixed(), {}),
        pytest.param(Terrain.stairs(rise=-0.06), {}, marks=pytest.mark.slow),
        pytest.param(Terrain.random(seed=3), {}, marks=pytest.mark.slow),
        pytest.param(Terrain.slopes(change_deg=1.5), {"control_period": 5e-3}, marks=pytest.mark.slow),
        (Terrain.from_segments([(0.30, 2.0), (10.0, 2.0, 0.05)]), {}),  # struck, and then it falls
    ],
    ids=["level", "mixed", "stairs", "random", "slow controller", "riser"],
)
def test_same_walk_bitwise(terrain: Terrain, parameters: dict[str, object], controller: AdaptiveController) -> None:
    """No tolerance: compiled code does the same operations in the same order, and takes sines from the same library."""
    states = []
    for compile in (False, True):
        simulation = make(controller, terrain, compile=compile, **parameters)
        with simulation.callbacks():
            assert simulation.compiled == compile
            mujoco.mj_step(simulation.model, simulation.data, nstep=20_000)  # on the riser they are of 10 µs
        assert simulation.state.count >= 1
        states.append(state_of(simulation.model, simulation.data))
    assert states[0] == states[1]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("terrain", "engine", "sample_period"),
    [
        (Terrain.level(), mjbiped.Mujoco(), 100.0),
        (Terrain.mixed(), mjbiped.Mujoco(), 1e-3),
        (Terrain.stairs(rise=-0.06), mjbiped.Mujoco(timestep=2e-4), 5e-3),
        (Terrain.random(seed=5), mjbiped.Mujoco(control_period=5e-3, timestep=5e-4), 5e-3),
    ],
    ids=["level", "mixed", "stairs", "random"],
)
def test_same_record(
    terrain: Terrain,
    engine: mjbiped.Mujoco,
    sample_period: float,
    controller: AdaptiveController,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Samples, touchdowns, peaks, end: though compiled walks are stepped in blocks, with touchdowns in their midst."""
    compiled = mjbiped.walk(controller, terrain, engine=engine, steps=3, sample_period=sample_period)
    monkeypatch.setattr(Simulation, "native", None)
    assert compiled == mjbiped.walk(controller, terrain, engine=engine, steps=3, sample_period=sample_period)
    assert compiled.steps == 3


def making_a_list(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> None:
    numbers = [0.0 * q[0]]
    numbers.append(t)
    out[0] = out[1] = numbers[0]


def test_a_law_that_cannot_be_compiled_is_refused_in_words() -> None:
    class Wrong(PassiveController):
        def law(self) -> Law:
            return super().law()._replace(torque=making_a_list)

    with pytest.raises(LawError, match=r"laws of Wrong .*torque \(making_a_list\): it allocates memory"):
        mjbiped.walk(Wrong(), Terrain.incline(2.0), steps=1)


def test_a_method_of_the_object_itself_is_called() -> None:
    def torque(memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        return 0.0, 1.0

    controller = PassiveController()
    object.__setattr__(controller, "torque", torque)
    simulation = make(controller)
    assert not simulation.compiled
    with simulation.callbacks():
        mujoco.mj_step(simulation.model, simulation.data)
    assert simulation.data.ctrl[2] == 1.0


def test_passive_walk_bitwise_to_its_end() -> None:
    """It falls: outcomes, too, are the same."""
    states = []
    for compile in (False, True):
        simulation = make(PassiveController(), Terrain.level(), compile=compile, q=(-0.3, 0.3), dq=(0.2, 0.1))
        with simulation.callbacks():
            mujoco.mj_step(simulation.model, simulation.data, nstep=2000)
        assert simulation.outcome is Outcome.FELL
        states.append(state_of(simulation.model, simulation.data))
    assert states[0] == states[1]


def test_warnings_of_steps_made_twice_count_once(
    monkeypatch: pytest.MonkeyPatch, controller: AdaptiveController
) -> None:
    """A block with the walk's end in it is taken back; its warnings once stayed."""
    simulation, step = make(controller, steps=2), mujoco.mj_step

    def warning_step(model: mujoco.MjModel, data: mujoco.MjData, nstep: int = 1) -> None:
        step(model, data, nstep=nstep)
        simulation.warnings["of each step"] += nstep

    monkeypatch.setattr(mujoco, "mj_step", warning_step)
    simulate(simulation, Recorder())
    assert simulation.state.count == 2
    times: list[float] = []
    again = make(controller, steps=2, compile=False)  # whose steps are made one by one

    def counting_step(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        times.append(data.time)
        step(model, data)

    monkeypatch.setattr(mujoco, "mj_step", counting_step)
    simulate(again, Recorder())
    assert simulation.warnings["of each step"] == len(times)


def test_one_model_serves_walks_of_many_gains_in_threads(controller: AdaptiveController) -> None:
    gains = (5.0, 3.0, 8.0)
    walkers = [make(replace(controller, position_gain=gain), lands=False) for gain in gains]
    alone = []
    for walker in walkers:
        with walker.callbacks():
            mujoco.mj_step(walker.model, walker.data, nstep=3000)
        alone.append(state_of(walker.model, walker.data))
    fresh = [make(replace(controller, position_gain=gain), lands=False) for gain in gains]
    shared = fresh[0].model
    natives = [walker.native for walker in fresh]
    assert natives[0]
    functions = natives[0].functions
    assert all(each and each.functions is functions for each in natives)
    datas = []
    for index, walker in enumerate(fresh):
        data = mujoco.MjData(shared)
        data.qpos, data.qvel, data.userdata = walker.data.qpos, walker.data.qvel, walker.data.userdata
        State.from_buffer(data.userdata).record = index
        datas.append(data)
    with fresh[0].callbacks(), attached(shared, [each for each in natives if each]):
        threads = [threading.Thread(target=mujoco.mj_step, args=(shared, data, 3000)) for data in datas]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    for index, data in enumerate(datas):
        state = State.from_buffer(data.userdata)
        assert state.record == index
        state.record = 0.0
        assert state_of(shared, data) == alone[index]


@pytest.mark.slow
def test_records_of_another_kind_are_refused(controller: AdaptiveController) -> None:
    """Of laws with more states, or of a ground with another number of risers: C code looks at no bounds."""
    fixed: dict[str, object] = {"lands": False}
    level, stairs = make(controller, Terrain.level(), **fixed), make(controller, Terrain.stairs(rise=-0.06), **fixed)
    many, lands = make(NineStates(), Terrain.level(), **fixed), make(controller, Terrain.level()).native
    own, other, unlike = level.native, stairs.native, many.native
    assert own
    assert other
    assert unlike
    for walks in ([other], [own, unlike]):
        with pytest.raises(ValueError, match="the same machine code"), attached(level.model, walks):
            pass
    with pytest.raises(ValueError, match="a model each"), attached(level.model, [own, lands]):  # type: ignore[list-item]
        pass
    with attached(level.model, [own, own]):
        assert level.model.numeric(RECORDS).data[COUNT] == 2


@pytest.mark.parametrize("record", [1.0, -1.0, math.nan, 1e300])
def test_a_record_that_is_not_there_is_not_read(record: float, controller: AdaptiveController) -> None:
    simulation = make(controller)
    simulation.state.record = record
    with simulation.callbacks():
        mujoco.mj_step(simulation.model, simulation.data, nstep=10)
    assert not simulation.data.ctrl.any()


def test_copies_of_a_model_are_left_alone(controller: AdaptiveController) -> None:
    """The addresses in its numeric field are copied with it, and may outlive what they point to."""
    simulation = make(controller)
    with simulation.callbacks():
        twin = copy.copy(simulation.model)
        data = mujoco.MjData(twin)
        data.qpos, data.qvel, data.userdata = simulation.data.qpos, simulation.data.qvel, simulation.data.userdata
        assert simulation.model.numeric(RECORDS).data.any()
        mujoco.mj_step(twin, data, nstep=10)
    assert not data.ctrl.any()
    assert not simulation.model.numeric(RECORDS).data.any()


class Raising(PassiveController):
    """Its law may raise an exception, which a C callback could not."""

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        out = [0.0, 0.0]
        raising_torque((), memory, t, q, dq, out)
        return out

    def law(self) -> Law:
        return PassiveController().law()._replace(torque=raising_torque)


def raising_torque(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> None:
    if t > 0.01:
        raise ValueError("late")
    out[0] = out[1] = 0.0


class Spring(Controller):
    """Without `law`."""

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        return 0.0, -20.0 * (q[1] - q[0])


def test_what_cannot_be_compiled_runs_in_python() -> None:
    for controller in (Spring(), Raising()):
        simulation = make(controller)
        assert not simulation.compiled
    assert raises((raising_torque,))
    with pytest.raises(mjbiped.WalkStopped, match="ValueError: late"):
        mjbiped.walk(Raising(), Terrain.incline(2.0), steps=1)


def out_of_range(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> None:
    out[0], out[1] = (0.0, 1.0)[int(100.0 * t)], 0.0


def test_an_exception_in_compiled_code_stops_the_walk() -> None:
    class Short(PassiveController):
        def law(self) -> Law:
            return super().law()._replace(torque=out_of_range)

    with pytest.raises(mjbiped.WalkStopped, match=r"Short failed at .* a compiled law raised an exception") as stopped:
        mjbiped.walk(Short(), Terrain.incline(2.0), steps=1)
    assert stopped.value.walk.outcome == "interrupted"
    assert 0.0199 < stopped.value.walk.end[0] < 0.0215  # the first step of 1 ms behind it


def test_unknown_mujoco_warns_once_and_walks(monkeypatch: pytest.MonkeyPatch, controller: AdaptiveController) -> None:
    def unknown() -> None:
        raise UnknownLayoutError("MuJoCo 9.9 is not understood")

    monkeypatch.setattr("mjbiped.engines.mujoco.compiled.callbacks.layout", unknown)
    physics.warn_once.cache_clear()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for _ in range(2):
            simulation = make(controller)
            with simulation.callbacks():
                mujoco.mj_step(simulation.model, simulation.data, nstep=3)
            assert not simulation.compiled
            assert simulation.data.ctrl.any()
    words = "MuJoCo 9.9 is not understood; walks run with callbacks in Python, which gives the same, only slower"
    assert [str(warning.message) for warning in caught] == [words]


@pytest.mark.slow
def test_callbacks_of_others_are_asked_for_other_models(controller: AdaptiveController) -> None:
    """Python's that stood there before, and compiled ones of another kind."""
    seen: list[mujoco.MjModel] = []

    def standing_there(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        del data
        seen.append(model)

    outer, inner = make(controller), make(NineStates(), Terrain.incline(2.0))
    mujoco.set_mjcb_control(standing_there)
    try:
        with inner.callbacks():
            mujoco.mj_step(outer.model, outer.data)
            mujoco.mj_step(inner.model, inner.data, nstep=20)
        assert seen == [outer.model]
        assert inner.state.time > 0.0
        assert mujoco.get_mjcb_control() is standing_there
    finally:
        mujoco.set_mjcb_control(None)
    alone, outer = make(controller), make(controller)
    with alone.callbacks():
        mujoco.mj_step(alone.model, alone.data, nstep=2000)
    inner = make(NineStates(), Terrain.incline(2.0))
    with outer.callbacks(), inner.callbacks():
        mujoco.mj_step(outer.model, outer.data, nstep=2000)
        mujoco.mj_step(inner.model, inner.data, nstep=20)
    assert inner.state.time > 0.0
    assert state_of(outer.model, outer.data) == state_of(alone.model, alone.data)


def test_records_hold_numbers_alone() -> None:
    packer = Packer()
    value = (1.5, True, 3, np.arange(6.0).reshape(2, 3), ())
    space = {
        "p": None,
        "record": 0,
        "array": lambda address, shape: packer.record()[address // 8 :][: math.prod(shape)].reshape(shape),
    }
    expression = packer.add(value)
    again = eval(expression, {**space, "p": packer.record()})
    assert again[:3] == value[:3]
    assert isinstance(again[2], int)
    assert np.array_equal(again[3], value[3])
    for odd in ("text", {"k": 1.0}, np.array([1, 2]), 1 << 60):
        with pytest.raises(NotPackableError):
            Packer().add(odd)
