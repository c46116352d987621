"""Laws as machine code: bitwise the law, one engine for all of them, failures that are noticed or named."""

import ctypes
import math
from typing import Any

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController, KneedController, LawController, PassiveController, never
from mjbiped.control.compiled import LawError, MachineCode, as_machine_code, can_be_compiled, compilable_law
from mjbiped.control.controller import ROOM, Law
from mjbiped.control.registry import controller_names, make_controller

NUMBER, ADDRESS = ctypes.c_double, ctypes.c_int64
QUICK = ("adaptive", "passive")


OTHERS = (pytest.param(name, marks=pytest.mark.slow) for name in controller_names() if name not in QUICK)


@pytest.mark.parametrize("name", [*QUICK, *OTHERS])
def test_machine_code_computes_as_methods_do(name: str, robot: mjbiped.Compass, gait: mjbiped.Gait) -> None:
    """Bit by bit."""
    controller = make_controller(name, robot, {}, gait)
    law = compilable_law(controller)
    assert law is not None
    code, count = MachineCode(controller, law), 2 + len(controller.states)
    memory, plain, out = np.zeros(controller.memory_size), [0.0] * controller.memory_size, np.zeros(count + ROOM)
    q, dq, before = (-0.17, 0.21), (1.05, 0.4), (0.22, -0.19)
    there, turning, old = (np.array(each) for each in (q, dq, before))
    state, kept = (there.ctypes.data, turning.ctypes.data), (code.law.parameters, memory.ctypes.data)
    controller.start(plain, q, dq)
    memory[:] = plain
    ctypes.CFUNCTYPE(None, *[ADDRESS] * 5)(code.law.touchdown)(*kept, old.ctypes.data, *state)
    law.touchdown(law.parameters, plain, before, q, dq)
    assert memory.tolist() == plain
    torque = ctypes.CFUNCTYPE(None, ADDRESS, ADDRESS, NUMBER, *[ADDRESS] * 3)(code.law.torque)
    found = ctypes.CFUNCTYPE(NUMBER, ADDRESS, ADDRESS, NUMBER)(code.law.next_discontinuity)
    for t in (0.0, 0.31, 0.9):
        expected = [math.nan] * (count + ROOM)
        law.torque(law.parameters, plain, t, q, dq, expected)
        torque(*kept, t, *state, out.ctypes.data)
        assert out[:count].tolist() == expected[:count] == list(controller.torque(plain, t, q, dq))
        kink = law.next_discontinuity(law.parameters, plain, t)
        assert found(*kept, t) == kink == controller.next_discontinuity(plain, t)
    estimate = ctypes.CFUNCTYPE(NUMBER, ADDRESS, ADDRESS)(code.law.slope_estimate)(*kept)
    np.testing.assert_equal(estimate, law.slope_estimate(law.parameters, plain))
    np.testing.assert_equal(estimate, controller.slope_estimate(plain))
    assert not code.failed


def test_one_machine_code_serves_all_gaits_and_robots_of_a_law(gait: mjbiped.Gait) -> None:
    """Parameters differ in number and value, never in type; laws with knees are those of straight legs."""
    heavy, kneed = mjbiped.Compass(hip_mass=3.0), mjbiped.KneedBiped()
    controllers = (
        AdaptiveController(mjbiped.Compass(), gait),
        AdaptiveController(heavy, mjbiped.find_passive_gait(heavy, math.radians(3.0))),
        KneedController(kneed, mjbiped.find_kneed_gait(kneed, math.radians(2.5))),
    )
    assert len({len(each.law().parameters) for each in controllers}) > 1
    assert len({as_machine_code(each).law.torque for each in controllers}) == 1


def out_of_range(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> None:
    out[0], out[1] = (0.0, 1.0)[int(100.0 * t)], 0.0


class Failing(PassiveController):
    def law(self) -> Law:
        return super().law()._replace(torque=out_of_range)


@pytest.mark.slow
@pytest.mark.compiled
@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_a_law_that_fails_in_machine_code_stops_the_walk_there(engine: str, gait: mjbiped.Gait) -> None:
    """What would come of a memory that is half written is no walk."""
    with pytest.raises(mjbiped.WalkStopped, match="a compiled law raised an exception") as stopped:
        mjbiped.walk(Failing(), mjbiped.Terrain.incline(2.0), engine=engine, initial=gait.start.tolist())
    # the hybrid engine keeps whole integration steps alone
    assert engine == "hybrid" or stopped.value.walk.end[0] == pytest.approx(0.02, abs=1.5e-3)
    assert stopped.value.walk.end[0] < 0.0215


def raising(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> None:
    if t > 0.01:
        raise ValueError("late")
    out[0] = out[1] = 0.0


def test_what_cannot_be_compiled(controller: AdaptiveController) -> None:
    law = PassiveController().law()
    assert can_be_compiled(law)
    changed: tuple[Any, ...] = ({"torque": raising}, {"parameters": ("a text",)}, {"parameters": ((1.0, 2.0),)})
    for each in changed:
        assert not can_be_compiled(law._replace(**each))

    class Weak(AdaptiveController):
        """A torque of its own, which the law that it inherits does not know."""

        def torque(self, memory, t, q, dq):  # type: ignore[no-untyped-def]
            return tuple(0.5 * each for each in super().torque(memory, t, q, dq))

    assert compilable_law(Weak(controller.robot, controller.gait)) is None


def good_torque(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> Any:
    out[0], out[1] = 0.0, 0


def makes_list(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> Any:
    numbers = [q[0], q[1]]
    numbers.append(t)
    out[0] = numbers[0]


def misspelt(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> Any:
    out[0] = sine(q[0])  # type: ignore[name-defined]  # noqa: F821


def returning_pair(parameters: Any, memory: Any) -> Any:
    return 0.0, 0.0


class ByLaw(LawController):
    def __init__(self, **changed: Any) -> None:
        self.given = Law((1.0,), good_torque, next_discontinuity=never)._replace(**changed)

    @property
    def plain_law(self) -> Law:
        return self.given


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"torque": makes_list}, ["torque (makes_list): it allocates memory", "of test_compiled.py"]),
        ({"torque": misspelt}, ["torque (misspelt): NameError: name 'sine' is not defined"]),
        ({"slope_estimate": returning_pair}, ["slope_estimate (returning_pair) returns ", "expected a float"]),
        ({"next_discontinuity": returning_pair}, ["next_discontinuity (returning_pair): ", "2 arguments"]),
    ],
    ids=lambda value: next(iter(value.values())).__name__ if isinstance(value, dict) else "",
)
def test_the_law_to_blame_is_named(changed: dict[str, Any], words: list[str]) -> None:
    good, bad = ByLaw(), ByLaw(**changed)
    assert not MachineCode(good, good.given).failed
    with pytest.raises(LawError) as refused:
        MachineCode(bad, bad.given)
    assert all(word in str(refused.value) for word in ["the laws of ByLaw cannot be compiled: ", *words])
