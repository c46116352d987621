"""Laws as machine code of their own: bitwise the law, one engine for all of them, and failures that are noticed."""

from __future__ import annotations

import ctypes
import math
from typing import ClassVar

import numba
import numpy as np
import pytest
from simulations import hybrid_run, make_simulation

import mjbiped
from controllers import AdaptiveController, KneedController, PassiveController, PassivityController
from mjbiped.control.compilation import MachineCode, can_be_compiled
from mjbiped.control.controller import Controller, Law, Memory
from mjbiped.control.registry import controller_names, make_controller
from mjbiped.engines.hybrid.run import HybridRun

NUMBER, ADDRESS = ctypes.c_double, ctypes.c_int64


QUICK = ("adaptive", "passive")


@pytest.mark.parametrize(
    "name",
    [*QUICK, *(pytest.param(name, marks=pytest.mark.slow) for name in controller_names() if name not in QUICK)],
)
def test_machine_code_computes_what_the_law_does(name: str, robot: mjbiped.Compass, gait: mjbiped.Gait) -> None:
    """Bit by bit."""
    controller = make_controller(name, robot, {}, gait)
    law = controller.law()
    assert law is not None
    assert can_be_compiled(law)
    code = MachineCode(law, len(controller.states), controller.memory_size)
    torque = ctypes.CFUNCTYPE(None, ADDRESS, ADDRESS, *[NUMBER] * 5, ADDRESS)(code.law.torque)
    touchdown = ctypes.CFUNCTYPE(None, ADDRESS, ADDRESS, *[NUMBER] * 6)(code.law.touchdown)
    at = ctypes.CFUNCTYPE(NUMBER, ADDRESS, ADDRESS, NUMBER)
    memory, plain, out = np.zeros(controller.memory_size), [0.0] * controller.memory_size, np.zeros(8)
    state = (-0.17, 0.21, 1.05, 0.4)
    controller.start(plain, state[:2], state[2:])
    memory[:] = plain
    touchdown(code.law.record, memory.ctypes.data, 0.22, -0.19, *state)
    law.touchdown(law.parameters, plain, 0.22, -0.19, *state)
    assert memory.tolist() == plain
    for t in (0.0, 0.31, 0.9):
        expected = law.torque(law.parameters, plain, t, *state)
        torque(code.law.record, memory.ctypes.data, t, *state, out.ctypes.data)
        assert out[: len(expected)].tolist() == list(expected)
        assert len(expected) == len(code.law.values)
        found = at(code.law.next_discontinuity)(code.law.record, memory.ctypes.data, t)
        assert found == law.next_discontinuity(law.parameters, plain, t)
    estimate = at(code.law.slope_estimate)(code.law.record, memory.ctypes.data, 0.0)
    np.testing.assert_equal(estimate, law.slope_estimate(law.parameters, plain))
    assert not code.failed


def test_idle_states_stand_before_the_laws_own(robot: mjbiped.Compass, gait: mjbiped.Gait) -> None:
    """They stay as they are, and the law does not see them."""
    controller = make_controller("adaptive", robot, {}, gait)
    law = controller.law()
    assert law is not None
    begun, state = [0.0] * controller.memory_size, (-0.17, 0.21, 1.05, 0.4)
    controller.start(begun, state[:2], state[2:])
    memory, behind, found = np.array(begun), np.array([math.pi, math.e, *begun]), []
    for idle, given in ((0, memory), (2, behind)):
        code = MachineCode(law, len(controller.states), controller.memory_size, idle=idle)
        torque = ctypes.CFUNCTYPE(None, ADDRESS, ADDRESS, *[NUMBER] * 5, ADDRESS)(code.law.torque)
        touchdown = ctypes.CFUNCTYPE(None, ADDRESS, ADDRESS, *[NUMBER] * 6)(code.law.touchdown)
        out = np.full(len(code.law.values), math.nan)
        touchdown(code.law.record, given.ctypes.data, 0.22, -0.19, *state)
        torque(code.law.record, given.ctypes.data, 0.2, *state, out.ctypes.data)
        found.append(out.tolist())
    assert behind.tolist() == [math.pi, math.e, *memory]
    assert found[1] == [*found[0][:2], 0.0, 0.0, *found[0][2:]]


def out_of_range(
    parameters: tuple[()], memory: Memory, t: float, q1: float, q2: float, dq1: float, dq2: float
) -> tuple[float, float]:
    return (0.0, 1.0)[int(100.0 * t)], 0.0


def raising(
    parameters: tuple[()], memory: Memory, t: float, q1: float, q2: float, dq1: float, dq2: float
) -> tuple[float, float]:
    if t > 0.01:
        raise ValueError("late")
    return 0.0, 0.0


def out_of_range_at_touchdown(
    parameters: tuple[()],
    memory: Memory,
    q1_before: float,
    q2_before: float,
    q1: float,
    q2: float,
    dq1: float,
    dq2: float,
) -> None:
    memory[0] = (0.0, 1.0)[2 + int(q1)]


class Failing(PassiveController):
    def law(self) -> Law:
        return super().law()._replace(torque=out_of_range)


class FailingAtTouchdown(PassiveController):
    memory_size: ClassVar[int] = 1

    def law(self) -> Law:
        return super().law()._replace(touchdown=out_of_range_at_touchdown)


@pytest.mark.slow
@pytest.mark.compiled
@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_a_law_that_fails_at_a_touchdown_stops_the_walk_there(engine: str, gait: mjbiped.Gait) -> None:
    """What would come of a memory that is half written is no walk."""
    with pytest.raises(mjbiped.WalkStopped, match="a compiled law raised an exception") as stopped:
        mjbiped.walk(
            FailingAtTouchdown(), mjbiped.Terrain.incline(2.0), engine=engine, steps=20, initial=gait.start.tolist()
        )
    assert stopped.value.walk.steps <= 1
    assert stopped.value.walk.end[0] == pytest.approx(gait.period, abs=1e-3)  # MuJoCo's steps are 0.06 ms shorter


@pytest.mark.slow
@pytest.mark.compiled
@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_a_law_that_fails_in_machine_code_stops_the_walk(engine: str) -> None:
    with pytest.raises(mjbiped.WalkStopped, match="a compiled law raised an exception") as stopped:
        mjbiped.walk(Failing(), mjbiped.Terrain.incline(2.0), engine=engine, steps=1)
    # an index beyond the tuple from 0.02 s on, noted a step of 1 ms later in MuJoCo; the hybrid engine keeps whole
    # integration steps alone
    assert stopped.value.walk.end[0] < 0.0215


def test_what_cannot_be_compiled() -> None:
    law = PassiveController().law()
    assert can_be_compiled(law)
    assert not can_be_compiled(law._replace(torque=raising))
    assert not can_be_compiled(law._replace(parameters=("a text",)))


def hybrid(controller: Controller) -> HybridRun:
    return hybrid_run(
        controller, mjbiped.Terrain.level(), robot=mjbiped.Compass(), q=(-0.19, 0.19), dq=(1.1, 0.8), steps=1
    )


@pytest.mark.slow
@pytest.mark.compiled
def test_one_machine_code_of_an_engine_serves_all_laws_with_as_many_states(
    robot: mjbiped.Compass, gait: mjbiped.Gait, controller: AdaptiveController
) -> None:
    alike = PassivityController(robot, gait), PassiveController(), Failing()
    assert len({id(hybrid(each).advance) for each in alike}) == 1
    assert hybrid(controller).advance is not hybrid(alike[0]).advance  # two states more are integrated
    made = [
        make_simulation(each, mjbiped.Terrain.level(), robot=robot, q=(0.0, 0.0), dq=(0.0, 0.0), steps=1)
        for each in alike
    ]
    assert all(simulation.compiled for simulation in made)
    assert len({id(simulation._advance) for simulation in made}) == 1


@pytest.mark.slow
@pytest.mark.compiled
def test_one_machine_code_of_the_hybrid_engine_serves_nearly_all_with_knees() -> None:
    """Controllers without states of their own have idle ones."""
    robot = mjbiped.KneedBiped()
    gait = mjbiped.find_kneed_gait(robot, slope=math.radians(2.5))
    passive, adaptive = (
        hybrid_run(each, mjbiped.Terrain.level(), robot=robot, q=tuple(gait.start[:3]), dq=tuple(gait.start[3:]))
        for each in (PassiveController().driving(robot), KneedController(robot, gait))
    )
    assert passive.advance is adaptive.advance
    types = [tuple(map(numba.typeof, (each.parameters, each.constants, each.state))) for each in (passive, adaptive)]
    assert types[0] == types[1]
