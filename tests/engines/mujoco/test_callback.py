"""`mjcb_control`, which is all that acts in a loop of one's own: whom it drives, and what it leaves alone."""

import copy
import re
import textwrap
import threading
from collections.abc import Callable, Sequence
from typing import Any

import mujoco
import numpy as np
import pytest
from simulations import put, started, state_of

import mjbiped
from controllers import AdaptiveController, Controller, Memory, PassiveController
from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.rules.termination import Outcome

Terrain = mjbiped.Terrain
LEVEL = Terrain.level()
PLAIN: dict[str, Any] = {"lands": False, "timestep": 1e-4}
both = pytest.mark.parametrize("compile", [pytest.param(True, marks=pytest.mark.compiled), False])


def steps(simulation: Simulation, count: int) -> None:
    mujoco.mj_step(simulation.model, simulation.data, nstep=count)


def test_example_of_the_docstring_runs() -> None:
    """As it stands, with the names that a reader has imported."""
    example = re.search(r"```python\n(.*?)```", Simulation.__doc__ or "", re.DOTALL)
    assert example
    names: dict[str, Any] = {"AdaptiveController": AdaptiveController, "mjbiped": mjbiped, "mujoco": mujoco, "np": np}
    exec(textwrap.dedent(example[1]), names)
    assert names["simulation"].data.time > 0.1
    assert names["simulation"].outcome is Outcome.WALKING


@pytest.mark.compiled
def test_plain_steps_are_the_same_in_python(controller: AdaptiveController) -> None:
    """Bit by bit, over a touchdown."""
    made = [started(controller, Terrain.stairs(rise=-0.06), compile=compile, **PLAIN) for compile in (True, False)]
    for simulation in made:
        with simulation.callbacks():
            steps(simulation, 8000)
    assert made[0].state.count >= 1.0
    assert state_of(made[0]) == state_of(made[1])


@pytest.mark.parametrize(("compile", "length"), [pytest.param(True, 8000, marks=pytest.mark.compiled), (False, 1000)])
def test_extra_forward_calls_change_nothing(compile: bool, length: int, controller: AdaptiveController) -> None:
    """Bitwise, of a robot without knees: a viewer or an integrator may call back again at the same time."""
    plain, disturbed = (started(controller, LEVEL, compile=compile, **PLAIN) for _ in range(2))
    with plain.callbacks():
        steps(plain, length)
    with disturbed.callbacks():
        for _ in range(length):
            mujoco.mj_forward(disturbed.model, disturbed.data)
            steps(disturbed, 1)
    assert plain.state.count >= float(compile)
    assert state_of(plain) == state_of(disturbed)


@both
def test_neither_zeroed_userdata_nor_copies_are_driven(compile: bool, controller: AdaptiveController) -> None:
    """Of the data, or of the model as well: what is copied with them names the walk of which they are no part."""
    simulation = started(controller, LEVEL, compile=compile, **PLAIN)
    with simulation.callbacks():
        for model in (simulation.model, copy.copy(simulation.model)):
            before, data = state_of(simulation), mujoco.MjData(model)
            data.qpos, data.qvel, data.userdata = simulation.data.qpos, simulation.data.qvel, simulation.data.userdata
            mujoco.mj_step(model, data, nstep=10)
            assert not data.ctrl.any()
            assert state_of(simulation) == before
        mujoco.mj_resetData(simulation.model, simulation.data)
        steps(simulation, 10)
    assert not simulation.data.ctrl.any()
    assert not simulation.data.userdata.any()


FALLING = "<mujoco><worldbody><body><freejoint/><geom size='1'/></body></worldbody></mujoco>"


@both
def test_others_are_asked_for_their_models_and_stay(compile: bool, controller: AdaptiveController) -> None:
    """The callback is the process's: another model that is stepped meanwhile is driven by who was there before."""
    other, seen = mujoco.MjModel.from_xml_string(FALLING), []

    def theirs(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        seen.append(model)

    alone, simulation = (started(controller, LEVEL, compile=compile, **PLAIN) for _ in range(2))
    with alone.callbacks():
        steps(alone, 100)
        mujoco.mj_step(other, mujoco.MjData(other))
    mujoco.set_mjcb_control(theirs)
    try:
        with simulation.callbacks():
            steps(simulation, 100)
            mujoco.mj_step(other, mujoco.MjData(other))
        assert seen == [other]
        assert mujoco.get_mjcb_control() is theirs
        simulation.advance(1)
        assert mujoco.get_mjcb_control() is theirs
    finally:
        mujoco.set_mjcb_control(None)
    alone.advance(1)
    assert state_of(alone) == state_of(simulation)


class Broken(PassiveController):
    def __init__(self, error: BaseException) -> None:
        object.__setattr__(self, "error", error)

    def law(self) -> None:  # type: ignore[override]
        return None

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        raise self.error  # type: ignore[attr-defined]


@both
@pytest.mark.parametrize("call", [steps, Simulation.advance])
@pytest.mark.parametrize("error", [ValueError("broken"), KeyboardInterrupt()], ids=["exception", "ctrl-c"])
def test_what_a_controller_raises_is_raised_and_others_callbacks_come_back(
    compile: bool, call: Callable[[Simulation, int], object], error: BaseException
) -> None:
    def theirs(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Nothing."""

    names = [name for name in dir(mujoco) if name.startswith("get_mj")]
    simulation = started(Broken(error), LEVEL, compile=compile, **PLAIN)
    mujoco.set_mjcb_control(theirs)
    try:
        before = [getattr(mujoco, name)() for name in names]
        with pytest.raises(type(error)), simulation.callbacks():
            call(simulation, 3)
        assert [getattr(mujoco, name)() for name in names] == before
    finally:
        mujoco.set_mjcb_control(None)
    assert not simulation.over


@both
def test_nested_simulations_are_both_driven(compile: bool, controller: AdaptiveController) -> None:
    """Whether the inner one is machine code or not, and by blocks of its own."""
    alone, outer, inner, other = (
        started(controller, LEVEL, compile=each, **PLAIN) for each in (compile, compile, compile, not compile)
    )
    with alone.callbacks():
        steps(alone, 600)
    with outer.callbacks(), inner.callbacks(), other.callbacks():
        for simulation in (outer, inner, other):
            steps(simulation, 300)
        with outer.callbacks():
            steps(outer, 300)
        for simulation in (inner, other):
            steps(simulation, 300)
    assert state_of(alone) == state_of(outer) == state_of(inner) == state_of(other)


class Constant(Controller):
    """A constant hip torque, and a count of its ticks."""

    states = ("ticks",)
    memory_size = 1

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        return 0.0, 0.5, 1.0


@pytest.mark.parametrize("how", ["steps", "advance"])
def test_controller_ticks_once_per_control_period(how: str) -> None:
    """It is asked at the times that it should be, and the state whose rate is 1 is a clock."""
    asked: list[float] = []

    class Asked(Constant):
        def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
            asked.append(t)
            assert memory[0] == pytest.approx(t, abs=1e-15)
            return super().torque(memory, t, q, dq)

    settings: dict[str, Any] = PLAIN if how == "steps" else {"timestep": 5e-4}
    simulation = started(Asked(), LEVEL, control_period=2e-3, **settings)
    with simulation.callbacks():
        if how == "steps":
            steps(simulation, 100)
        else:
            simulation.advance(20)
    assert asked == pytest.approx([0.0, 2e-3, 4e-3, 6e-3, 8e-3], abs=1e-15)


@both
def test_a_state_of_another_simulation_goes_on_within_a_block(compile: bool, controller: AdaptiveController) -> None:
    """Whose a state is was in it, as an address."""
    one, other = (started(controller, LEVEL, compile=compile, **PLAIN) for _ in range(2))
    with one.callbacks(), other.callbacks():
        mujoco.mj_step(one.model, one.data, nstep=200)
        put(other, state_of(one))
        for each in (one, other):
            mujoco.mj_step(each.model, each.data, nstep=100)
    assert other.data.qpos.tobytes() == one.data.qpos.tobytes()
    assert other.state.time == one.state.time == pytest.approx(0.0299)


@both
def test_what_no_state_holds_is_not_taken_from_another_one(compile: bool) -> None:
    """Accelerations are the solver's guess, and contacts are none: those of before stood there still, or zeros."""
    robot = mjbiped.KneedBiped()
    one, other = (
        started(PassiveController(), mjbiped.Terrain.incline(2.5), robot=robot, compile=compile, **PLAIN)
        for _ in range(2)
    )
    with one.callbacks(), other.callbacks():
        mujoco.mj_step(one.model, one.data, nstep=50)
        put(other, state_of(one))
        other.data.sensordata[:] = other.data.qacc[:] = 1.0
        for each in (one, other):
            mujoco.mj_step(each.model, each.data)
    assert other.state.qacc[:] == one.state.qacc[:]
    assert (one.state.force > 0.0, other.state.force) == (True, 0.0)


@pytest.mark.compiled
@pytest.mark.parametrize("theirs", [None, print])
def test_walks_in_python_and_in_machine_code_go_on_in_threads(theirs: Any, controller: AdaptiveController) -> None:
    """With somebody's callback, which stays, while models are built.

    Callbacks behind MuJoCo's bindings left walks without torques for steps, or ended the process.
    """
    makers = [True, True, False, True, False]
    ends: list[list[bytes]] = [[] for _ in makers]

    def walk(compile: bool, into: list[bytes]) -> None:
        for _ in range(6 if compile else 2):
            simulation = started(controller, LEVEL, compile=compile)
            for _ in range(10):
                simulation.advance(10)
            into.append(state_of(simulation))

    threads = [threading.Thread(target=walk, args=each) for each in zip(makers, ends, strict=True)]
    mujoco.set_mjcb_control(theirs)
    try:
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert mujoco.get_mjcb_control() is theirs
    finally:
        mujoco.set_mjcb_control(None)
    assert len({end for each in ends for end in each}) == 1
