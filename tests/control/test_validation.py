"""What breaks a controller's contract is told before the walk; what appears on the way, in its record."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import pytest

import mjbiped
from controllers import Controller, PassiveController
from mjbiped.control.controller import Law, Memory, never
from mjbiped.control.functions import try_out
from mjbiped.control.registry import controller_names, make_controller
from mjbiped.errors import GaitError, InputError

Q, DQ = (-0.19, 0.19), (1.1, 0.8)


class Still(Controller):
    """Nothing, written so that parts of it can be replaced."""

    memory_size = 1

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Any:
        return 0.0, 0.0


def made(**parts: Any) -> Controller:
    controller: Controller = type("Law", (Still,), parts)()
    return controller


def returning(value: Any) -> Controller:
    return made(torque=lambda *_: value)


def written(index: int, value: Any) -> Any:
    def write(self: Controller, memory: Any, *_: object) -> Any:
        memory[index] = value
        return 0.0, 0.0

    return write


def counted(self: Any, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Any:
    self.calls = getattr(self, "calls", 0) + 1
    return 0.0, 0.0


@dataclass(frozen=True)
class Frozen(Still):
    """A frozen dataclass that counts its steps."""

    steps: int = 0

    def on_touchdown(self, memory: Memory, *_: object) -> None:
        self.steps += 1  # type: ignore[misc]  # that is what is wrong with it


def changed_later(self: Any, *_: object) -> None:
    self.kept[0] += 1.0


def forgetful(self: Controller, memory: Memory, q: object) -> Any:
    return 0.0, 0.0


CALLS = itertools.count()

REFUSED: dict[str, tuple[Controller, str]] = {
    "one number": (returning(1.5), r"Law.torque returned 1.5; expected 2: ankle, hip .*`return ankle, hip`"),
    "nothing": (returning(None), "Law.torque returned None; expected 2"),
    "text": (returning("ab"), "Law.torque returned 'ab'; expected 2"),
    "three": (returning((0.0, 0.0, 0.0)), "returned 3 values; expected 2"),
    "no rate": (
        made(states=("work",)),
        r"returned 2 values; expected 3: .*\(work\).*`return ankle, hip, rate_of_work`",
    ),
    "no number": (returning((0.0, "1")), "'1' in it is no number"),
    "array in it": (returning((0.0, np.zeros(2))), "in it is no number"),
    "nan": (returning((0.0, math.nan)), r"Law.torque gives nan for the hip torque at t = 0 s .*the walk cannot begin"),
    "infinite": (returning((-math.inf, math.nan)), "gives -inf for the ankle torque and nan for the hip torque"),
    "great": (returning((10**400, 0.0)), "for the ankle torque"),
    "rate": (
        made(states=("work",), torque=lambda *_: (0.0, 0.0, math.inf)),
        "gives inf for the rate of work",
    ),
    "memory in torque": (made(torque=written(0, 1.0)), r"Law.torque writes into memory\[0\].*return its rate"),
    "no memory": (made(memory_size=0, start=written(0, 1.0)), r"Law.start fails: .*memory_size says, 0"),
    "memory grows": (
        made(start=lambda _, memory, *__: memory.append(1.0)),
        "memory of 2 floats where memory_size = 1",
    ),
    "list in memory": (made(start=written(0, [1.0])), r"Law.start writes \[1.0\] into memory\[0\]"),
    "text at touchdown": (made(on_touchdown=written(0, "x")), r"Law.on_touchdown writes 'x' into memory\[0\]"),
    "attribute": (made(torque=counted), "Law sets its attribute calls while it walks; what lasts .*into the memory"),
    "frozen": (
        Frozen(),
        r"Frozen sets an attribute while it walks: cannot assign to field 'steps' \(test_validation.py, .* self.steps",
    ),
    "list in an attribute": (
        made(kept=[0.0], on_touchdown=changed_later, torque=lambda self, *_: (0.0, self.kept[0])),
        r"gives \(0.0, 0.0\) and then \(0.0, 1.0\) for the same arguments",
    ),
    "chance": (made(torque=lambda *_: (0.0, float(next(CALLS)))), "for the same arguments"),
    "parameters": (
        made(torque=forgetful),
        r"Law.torque does not take .*expected is def torque\(self, memory, t, q, dq\)",
    ),
    "touchdown's parameters": (made(on_touchdown=forgetful), "Law.on_touchdown.*memory, q_before"),
}


@pytest.mark.parametrize(("controller", "words"), REFUSED.values(), ids=REFUSED.keys())
def test_refused_before_the_walk(controller: Controller, words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mjbiped.engines.base.Run.go", lambda *_, **__: pytest.fail("it walked"))
    with pytest.raises(InputError, match=words):
        mjbiped.walk(controller, mjbiped.Terrain.incline(2.0), engine="hybrid")
    with pytest.raises(InputError, match="walk 0 of 1"):
        mjbiped.walk_many(controller, mjbiped.Terrain.incline(2.0), engine="hybrid")


class Computing(Controller):
    """Computes something once, and keeps a log that no torque depends on."""

    def __init__(self) -> None:
        self.log: list[float] = []

    @cached_property
    def gain(self) -> float:
        return 0.1

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Any:
        self.log.append(t)
        return np.array([0.0, -self.gain * q[1]])


class Bound(Controller):
    """Methods that are no ordinary ones."""

    @staticmethod
    def torque(*_: object) -> Any:
        return np.float32(0.0), 0

    @classmethod
    def start(cls, *_: object) -> None:
        pass


class Failing(Controller):
    """What it raises is the walk's to tell, which keeps what was walked."""

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Any:
        raise ZeroDivisionError


class FailingAtLast(Computing):
    """Fails when it is asked once more."""

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Any:
        self.log.append(t)
        return 0.0, 1.0 / (3 - len(self.log))


@pytest.mark.parametrize("controller", [Still(), Computing(), Bound(), Failing(), FailingAtLast()])
def test_what_keeps_the_contract_passes(controller: Controller) -> None:
    before = repr(vars(controller))
    try_out(controller, Q, DQ)
    assert repr(vars(controller)) == before, "it is a copy that is tried"


@pytest.mark.slow
@pytest.mark.parametrize("name", controller_names())
def test_every_controller_of_this_project_passes(name: str, robot: mjbiped.Compass, gait: mjbiped.Gait) -> None:
    try_out(make_controller(name, robot, {}, gait), Q, DQ)


def test_no_gait_to_start_on_is_told_with_a_way_out() -> None:
    with pytest.raises(GaitError, match=r'no passive gait .*Still imitates no gait .*give initial="rest"'):
        mjbiped.walk(Still(), mjbiped.Terrain.level())


class Breaking(Controller):
    """The ankle's torque is infinite after 0.3 s of a step, in plain Python."""

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Any:
        return (math.inf if t > 0.3 else 0.0), 0.0


def breaking(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> None:
    out[0], out[1] = (math.inf if t > 0.3 else 0.0), 0.0


def nothing(parameters: Any, memory: Any, q_before: Any, q: Any, dq: Any) -> None:
    pass


def no_estimate(parameters: Any, memory: Any) -> Any:
    return math.nan


@dataclass(frozen=True)
class BreakingCompiled(Controller):
    """The same, compiled."""

    states: ClassVar[tuple[str, ...]] = ()

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Any:
        out = [0.0, 0.0]
        breaking((), memory, t, q, dq, out)
        return tuple(out)

    def law(self) -> Law:
        return Law((), breaking, nothing, no_estimate, never)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
@pytest.mark.parametrize("controller", [Breaking(), BreakingCompiled()])
def test_torques_that_become_infinite_are_told_with_time_and_joint(controller: Controller, engine: str) -> None:
    walk = mjbiped.walk(controller, mjbiped.Terrain.incline(2.0), engine=engine)
    assert walk.outcome == "diverged"
    assert walk.end[0] == pytest.approx(0.3, abs=1.1e-3)  # MuJoCo's step is 1 ms
    assert len(walk.samples["time"]) > 50, "what was walked is kept"
    said = [text for text in walk.warnings if "ankle" in text]
    assert len(said) == 1
    assert f"{type(controller).__name__}.torque gives inf for the ankle torque at t = 0.3" in said[0]


def law_that_returns(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> Any:
    return 0.0, 0.0


def writing_one(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> None:
    out[0] = 0.0


@pytest.mark.parametrize(
    ("torque", "words"),
    [
        (law_that_returns, r"law\(\).torque returns \(0.0, 0.0\); expected are 2 numbers written into out"),
        (writing_one, r"law\(\).torque leaves out\[1\], the hip torque, unwritten"),
    ],
)
def test_a_law_that_does_not_write_its_torques_is_refused(torque: Any, words: str) -> None:
    class Silent(PassiveController):
        def law(self) -> Law:
            return super().law()._replace(torque=torque)

    with pytest.raises(InputError, match=words):
        mjbiped.walk(Silent(), mjbiped.Terrain.incline(2.0), engine="hybrid", steps=1)


def test_a_failure_names_the_line() -> None:
    def torque(self: Controller, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Any:
        return 0.0, math.sqrt(0.1 - t)

    with pytest.raises(
        mjbiped.WalkStopped,
        match=r"Law failed at 0\.\d+ s.*ValueError: .*\(test_validation.py, line \d+, in torque: return 0.0, math.sqrt",
    ) as caught:
        mjbiped.walk(made(torque=torque), mjbiped.Terrain.incline(2.0), engine="hybrid")
    assert caught.value.walk.end[0] > 0.05
