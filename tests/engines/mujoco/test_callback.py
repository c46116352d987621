"""`mjcb_control`, which is all that acts in a loop of one's own: whom it drives, and what it leaves alone."""

import copy
import re
import textwrap
import threading
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import mujoco
import numpy as np
import pytest
from simulations import put, started, state_of

import mjbiped
from controllers import AdaptiveController, Controller, Memory
from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.rules.termination import Outcome

Terrain = mjbiped.Terrain
LEVEL = Terrain.level()
PLAIN: dict[str, Any] = {"lands": False, "timestep": 1e-4}
both = pytest.mark.parametrize("compile", [pytest.param(True, marks=pytest.mark.compiled), False])
WHEEL = mujoco.MjModel.from_xml_string("<mujoco><worldbody><body><joint/><geom size='1'/></body></worldbody></mujoco>")


def steps(simulation: Simulation, count: int) -> None:
    mujoco.mj_step(simulation.model, simulation.data, nstep=count)


@pytest.fixture
def theirs() -> Iterator[list[mujoco.MjModel]]:
    """Somebody's callback, which writes down whom it is asked for, and has to be there in the end."""
    seen: list[mujoco.MjModel] = []

    def control(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        seen.append(model)

    mujoco.set_mjcb_control(control)
    yield seen
    found = mujoco.get_mjcb_control()
    mujoco.set_mjcb_control(None)
    assert found is control


@pytest.fixture(scope="module")
def alone(controller: AdaptiveController) -> bytes:
    """The state after 600 steps."""
    simulation = started(controller, LEVEL, compile=False, **PLAIN)
    with simulation.callbacks():
        steps(simulation, 600)
    return state_of(simulation)


def test_example_of_the_docstring_runs() -> None:
    """As it stands, with the names that a reader has imported."""
    example = re.search(r"```python\n(.*?)```", Simulation.__doc__ or "", re.DOTALL)
    assert example
    names: dict[str, Any] = {"AdaptiveController": AdaptiveController, "mjbiped": mjbiped, "mujoco": mujoco, "np": np}
    exec(textwrap.dedent(example[1]), names)
    assert names["simulation"].data.time > 0.1
    assert names["simulation"].outcome is Outcome.WALKING


@pytest.mark.compiled
def test_plain_steps_are_the_same_in_python_and_after_forward_calls(controller: AdaptiveController) -> None:
    """Bit by bit, over a touchdown: a viewer or an integrator may call back again at the same time."""
    made = [started(controller, Terrain.stairs(), compile=compile, **PLAIN) for compile in (True, False, True)]
    for simulation, forward in zip(made, (0, 0, 1), strict=True):
        with simulation.callbacks():
            for _ in range(8000):
                for _ in range(forward):
                    mujoco.mj_forward(simulation.model, simulation.data)
                steps(simulation, 1)
    assert made[0].state.count >= 1.0
    assert state_of(made[0]) == state_of(made[1]) == state_of(made[2])


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


@both
def test_others_are_asked_for_their_models_and_stay(
    compile: bool, controller: AdaptiveController, theirs: list[mujoco.MjModel], alone: bytes
) -> None:
    """The callback is the process's: another model that is stepped meanwhile is driven by who was there before."""
    simulation = started(controller, LEVEL, compile=compile, **PLAIN)
    with simulation.callbacks():
        steps(simulation, 600)
        mujoco.mj_step(WHEEL, mujoco.MjData(WHEEL))
    assert theirs == [WHEEL]
    assert state_of(simulation) == alone
    simulation.advance(1)


class Broken(Controller):
    """Raises an error in place of torques."""

    def __init__(self, error: BaseException) -> None:
        self.error = error

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        raise self.error


@both
@pytest.mark.parametrize("call", [steps, Simulation.advance])
@pytest.mark.parametrize("error", [ValueError("broken"), KeyboardInterrupt()], ids=["exception", "ctrl-c"])
@pytest.mark.usefixtures("theirs")
def test_what_a_controller_raises_is_raised_and_others_callbacks_come_back(
    compile: bool, call: Callable[[Simulation, int], object], error: BaseException
) -> None:
    names = [name for name in dir(mujoco) if name.startswith("get_mj")]
    simulation = started(Broken(error), LEVEL, compile=compile, **PLAIN)
    before = [getattr(mujoco, name)() for name in names]
    with pytest.raises(type(error)), simulation.callbacks():
        call(simulation, 3)
    assert [getattr(mujoco, name)() for name in names] == before
    assert not simulation.over


@both
def test_a_state_of_another_simulation_goes_on_within_a_block(compile: bool, controller: AdaptiveController) -> None:
    """Nothing is another one's that no state holds: an address, the solver's guess, contacts of before."""
    one, other = (started(controller, LEVEL, compile=compile, **PLAIN) for _ in range(2))
    with one.callbacks(), other.callbacks():
        steps(one, 50)
        put(other, state_of(one))
        for each in (one, other):
            steps(each, 100)
        assert other.data.qpos.tobytes() == one.data.qpos.tobytes()
        assert other.state.time == one.state.time == pytest.approx(0.0149)
        put(other, state_of(one))
        other.data.sensordata[:] = other.data.qacc[:] = 1.0
        for each in (one, other):
            steps(each, 1)
        assert other.state.qacc[:] == one.state.qacc[:]
        assert (one.state.force > 0.0, other.state.force) == (True, 0.0)


@pytest.mark.compiled
@pytest.mark.usefixtures("theirs")
def test_walks_in_python_and_in_machine_code_go_on_in_threads(controller: AdaptiveController) -> None:
    """With somebody's callback, which stays, while models are built.

    Callbacks behind MuJoCo's bindings left walks without torques for steps, or ended the process.
    """
    ends: list[bytes] = []

    def walk(compile: bool) -> None:
        for _ in range(6 if compile else 2):
            simulation = started(controller, LEVEL, compile=compile)
            for _ in range(10):
                simulation.advance(10)
            ends.append(state_of(simulation))

    threads = [threading.Thread(target=walk, args=(compile,)) for compile in (True, True, False, True, False)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert (len(ends), len(set(ends))) == (22, 1)
