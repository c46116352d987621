"""What every controller offers, one that a user writes, and what breaks the contract: told before the walk."""

import dataclasses
import itertools
import json
import math
from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
import pytest

import mjbiped
from controllers import Controller, Law, LawController, Memory
from mjbiped.control.functions import try_out

Q, DQ = (-0.19, 0.19), (1.1, 0.8)
GROUND = mjbiped.Terrain.incline(2.0)


class Still(Controller):
    """No torque, written so that parts of it can be replaced."""

    memory_size = 1

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Any:
        return 0.0, 0.0


@dataclasses.dataclass(frozen=True)
class Everything(Still):
    """Parameters of every kind, for the record."""

    robot: mjbiped.Compass
    gait: mjbiped.Gait
    gain: Any = 1.5
    count: int = 3
    switch: bool = True
    word: str = "x"
    nothing: None = None
    table: Any = dataclasses.field(default_factory=lambda: np.arange(3.0))


def test_description_is_json_whatever_the_parameters(robot: mjbiped.Compass, gait: mjbiped.Gait) -> None:
    description = Everything(robot, gait, gain=np.float32(1.5)).describe()
    assert json.loads(json.dumps(description, allow_nan=False)) == description
    told = {"robot": robot.to_dict(), "gait": gait.describe(), "table": "array([0., 1., 2.])"}
    plain = {"gain": 1.5, "count": 3, "switch": True, "word": "x", "nothing": None}
    assert description == {"name": "Everything", **told, **plain}


# --- what breaks the contract -----------------------------------------------------------------------------------------


def made(**parts: Any) -> Controller:
    controller: Controller = type("Law", (Still,), parts)()
    return controller


def returning(value: Any) -> Controller:
    return made(torque=lambda *_: value)


def by_law(torque: Any, **parts: Any) -> Controller:
    law = Law(**{"parameters": [], "torque": torque, **parts})
    controller: Controller = type("Law", (LawController,), {"plain_law": law})()
    return controller


def written(index: int, value: Any) -> Any:
    def write(self: Controller, memory: Any, *_: object) -> Any:
        memory[index] = value
        return 0.0, 0.0

    return write


def counted(self: Any, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Any:
    self.calls = getattr(self, "calls", 0) + 1
    return 0.0, 0.0


@dataclasses.dataclass(frozen=True)
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

REFUSED: list[tuple[Controller, str]] = [
    (returning(1.5), r"Law.torque returned 1.5; expected 2: ankle, hip .*`return ankle, hip`"),
    (made(states=("work",)), r"returned 2 values; expected 3: .*\(work\).*`return ankle, hip, rate_of_work`"),
    (returning((0.0, "1")), "'1' in it is no number"),
    (returning((0.0, math.nan)), r"Law.torque gives nan for the hip torque at t = 0 s .*the walk cannot begin"),
    (made(states=("work",), torque=lambda *_: (0.0, 0.0, math.inf)), "gives inf for the rate of work"),
    (made(torque=written(0, 1.0)), r"Law.torque writes into memory\[0\].*return its rate"),
    (made(memory_size=0, start=written(0, 1.0)), r"Law.start fails: .*memory_size says, 0"),
    (made(start=lambda _, memory, *__: memory.append(1.0)), "memory of 2 floats where memory_size = 1"),
    (made(start=written(0, [1.0])), r"Law.start writes \[1.0\] into memory\[0\]"),
    (made(on_touchdown=written(0, "x")), r"Law.on_touchdown writes 'x' into memory\[0\]"),
    (made(torque=counted), "Law sets its attribute calls while it walks; what lasts .*into the memory"),
    (Frozen(), r"Frozen sets an attribute while it walks: .*'steps' \(test_controller.py, .* self.steps"),
    (
        made(kept=[0.0], on_touchdown=changed_later, torque=lambda self, *_: (0.0, self.kept[0])),
        r"gives \(0.0, 0.0\) and then \(0.0, 1.0\) for the same arguments",
    ),
    (made(torque=lambda *_: (0.0, float(next(CALLS)))), "for the same arguments"),
    (made(torque=forgetful), r"Law.torque does not take .*expected is def torque\(self, memory, t, q, dq\)"),
    (by_law(lambda *_: (0.0, 0.0)), r"law\(\).torque returns \(0.0, 0.0\); expected are 2 numbers written into out"),
    (by_law(lambda *given: given[-1].__setitem__(0, 0.0)), r"leaves out\[1\], the hip torque, unwritten"),
    (by_law(forgetful), r"Law whose torque does not .*expected is def torque\(parameters, memory, t, q, dq, out\)"),
    (by_law(lambda *_: None, touchdown=forgetful), r"expected is def touchdown\(parameters, memory, q_before, q, dq\)"),
    (by_law(lambda *_: None, parameters=1.5), r"Law whose parameters are 1.5; expected a sequence of numbers"),
]


@pytest.mark.usefixtures("nothing_walks")
@pytest.mark.parametrize(("controller", "words"), REFUSED, ids=[words for _, words in REFUSED])
def test_refused_before_the_walk(controller: Controller, words: str) -> None:
    with pytest.raises(mjbiped.InputError, match=words):
        mjbiped.walk(controller, GROUND, engine="hybrid")


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


# methods that are no ordinary ones
BOUND = made(torque=staticmethod(lambda *_: (np.float32(0.0), 0)), start=classmethod(lambda *_: None))


@pytest.mark.parametrize("controller", [Still(), Computing(), BOUND])
def test_what_keeps_the_contract_passes(controller: Controller) -> None:
    before = repr(vars(controller))
    try_out(controller, Q, DQ)
    assert repr(vars(controller)) == before, "it is a copy that is tried"


def breaking(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> None:
    out[0], out[1] = (math.inf if t > 0.3 else 0.0), 0.0


BREAKING = made(torque=lambda _, __, t, *___: (math.inf if t > 0.3 else 0.0, 0.0))


@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
@pytest.mark.parametrize("controller", [BREAKING, pytest.param(by_law(breaking), marks=pytest.mark.slow)])
def test_torques_that_become_infinite_are_told_with_time_and_joint(controller: Controller, engine: str) -> None:
    walk = mjbiped.walk(controller, GROUND, engine=engine)
    assert walk.outcome == "diverged"
    assert walk.end[0] == pytest.approx(0.3, abs=1.1e-3)  # MuJoCo's step is 1 ms
    assert len(walk.samples["time"]) > 50, "what was walked is kept"
    said = [text for text in walk.warnings if "ankle" in text]
    assert len(said) == 1
    assert "Law.torque gives inf for the ankle torque at t = 0.3" in said[0]


def failing(self: Controller, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Any:
    return 0.0, math.sqrt(0.3 - t)


PLACE = r"\(test_controller.py, line \d+, in failing: return 0.0, math.sqrt"


@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
@pytest.mark.parametrize(
    ("controller", "words"),
    [
        (made(torque=failing), rf"Law failed at 0\.\d+ s.*ValueError: .*{PLACE}"),
        (made(memory_size=0, on_touchdown=written(0, 1.0)), "IndexError: .*memory_size says, 0: set that as you need"),
    ],
)
def test_a_failure_names_the_line_and_keeps_what_was_walked(controller: Controller, words: str, engine: str) -> None:
    with pytest.raises(mjbiped.WalkStopped, match=words) as caught:
        mjbiped.walk(controller, GROUND, engine=engine, steps=2)
    assert caught.value.walk.end[0] > 0.2  # of whole integration steps of some 0.05 s
