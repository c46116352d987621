"""Laws as machine code of their own: bitwise the law, one engine for all of them, and failures that are noticed."""

from __future__ import annotations

import ctypes
import math
from typing import Any, ClassVar

import numpy as np
import pytest
from simulations import hybrid_run, make_simulation

import mjbiped
from controllers import AdaptiveController, KneedController, PassiveController, PassivityController
from mjbiped.control.compiled import MachineCode, as_machine_code, can_be_compiled
from mjbiped.control.controller import ROOM, Controller, Law
from mjbiped.control.registry import controller_names, make_controller
from mjbiped.engines.hybrid.engine import HybridRun, engine_address

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
    code = MachineCode(controller, law)
    count = 2 + len(controller.states)
    memory, plain, out = np.zeros(controller.memory_size), [0.0] * controller.memory_size, np.zeros(count + ROOM)
    q, dq, before = (-0.17, 0.21), (1.05, 0.4), (0.22, -0.19)
    there, turning, old = (np.array(each) for each in (q, dq, before))
    state, record = (there.ctypes.data, turning.ctypes.data), code.law.parameters
    controller.start(plain, q, dq)
    memory[:] = plain
    touchdown(code)(record, memory.ctypes.data, old.ctypes.data, *state)
    law.touchdown(law.parameters, plain, before, q, dq)
    assert memory.tolist() == plain
    for t in (0.0, 0.31, 0.9):
        expected = [0.0] * (count + ROOM)
        law.torque(law.parameters, plain, t, q, dq, expected)
        torque(code)(record, memory.ctypes.data, t, *state, out.ctypes.data)
        assert out[:count].tolist() == expected[:count]
        found = ctypes.CFUNCTYPE(NUMBER, ADDRESS, ADDRESS, NUMBER)(code.law.next_discontinuity)
        assert found(record, memory.ctypes.data, t) == law.next_discontinuity(law.parameters, plain, t)
    estimate = ctypes.CFUNCTYPE(NUMBER, ADDRESS, ADDRESS)(code.law.slope_estimate)(record, memory.ctypes.data)
    np.testing.assert_equal(estimate, law.slope_estimate(law.parameters, plain))
    assert not code.failed


def torque(code: MachineCode) -> Any:
    """The C function of `Law.torque`."""
    return ctypes.CFUNCTYPE(None, ADDRESS, ADDRESS, NUMBER, *[ADDRESS] * 3)(code.law.torque)


def touchdown(code: MachineCode) -> Any:
    """The C function of `Law.touchdown`."""
    return ctypes.CFUNCTYPE(None, ADDRESS, ADDRESS, *[ADDRESS] * 3)(code.law.touchdown)


def count_up(parameters: Any, memory: Any, q_before: Any, q: Any, dq: Any) -> None:
    memory[0] += 1.0


def remembered(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> None:
    out[0], out[1] = memory[0], parameters[0]


def test_one_machine_code_serves_all_gaits_and_robots_of_a_law(gait: mjbiped.Gait) -> None:
    """Parameters differ in number and value, never in type; laws with knees are those of straight legs."""
    other = mjbiped.find_passive_gait(mjbiped.Compass(hip_mass=3.0), math.radians(3.0))
    kneed = mjbiped.KneedBiped()
    controllers = (
        AdaptiveController(mjbiped.Compass(), gait),
        AdaptiveController(mjbiped.Compass(hip_mass=3.0), other),
        KneedController(kneed, mjbiped.find_kneed_gait(kneed, math.radians(2.5))),
    )
    assert len({len(each.law().parameters) for each in controllers}) > 1
    assert len({as_machine_code(each).law.torque for each in controllers}) == 1


def out_of_range(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> None:
    out[0], out[1] = (0.0, 1.0)[int(100.0 * t)], 0.0


def raising(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> None:
    if t > 0.01:
        raise ValueError("late")
    out[0] = out[1] = 0.0


def out_of_range_at_touchdown(parameters: Any, memory: Any, q_before: Any, q: Any, dq: Any) -> None:
    memory[0] = (0.0, 1.0)[2 + int(q[0])]


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
    assert not can_be_compiled(law._replace(parameters=("a text",)))  # type: ignore[arg-type]
    assert not can_be_compiled(law._replace(parameters=((1.0, 2.0),)))  # type: ignore[arg-type]


def hybrid(controller: Controller) -> HybridRun:
    return hybrid_run(
        controller, mjbiped.Terrain.level(), robot=mjbiped.Compass(), q=(-0.19, 0.19), dq=(1.1, 0.8), steps=1
    )


@pytest.mark.slow
@pytest.mark.compiled
def test_one_machine_code_of_an_engine_serves_all_laws_with_as_many_states(
    robot: mjbiped.Compass, gait: mjbiped.Gait
) -> None:
    alike = PassivityController(robot, gait), PassiveController(), Failing()
    made = [
        make_simulation(each, mjbiped.Terrain.level(), robot=robot, q=(0.0, 0.0), dq=(0.0, 0.0), steps=1)
        for each in alike
    ]
    assert all(simulation.compiled for simulation in made)
    assert len({id(simulation._advance) for simulation in made}) == 1


@pytest.mark.slow
@pytest.mark.compiled
def test_one_machine_code_of_the_hybrid_engine_serves_all_robots_and_laws(controller: AdaptiveController) -> None:
    robot = mjbiped.KneedBiped()
    gait = mjbiped.find_kneed_gait(robot, slope=math.radians(2.5))
    kneed = (PassiveController().driving(robot), KneedController(robot, gait))
    runs = [
        hybrid(controller),
        *(
            hybrid_run(each, mjbiped.Terrain.level(), robot=robot, q=tuple(gait.start[:3]), dq=tuple(gait.start[3:]))
            for each in kneed
        ),
    ]
    assert len({run.machine and engine_address() for run in runs}) == 1
