"""Laws that cannot be compiled are refused before the walk, in words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

import mjbiped
from controllers import Controller, LawController
from mjbiped.control.compiled import LawError, MachineCode
from mjbiped.control.controller import Law, Memory
from mjbiped.errors import InputError
from mjbiped.terrain.terrain import Terrain


def good_torque(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> Any:
    out[0], out[1] = 0.0, 0


def good_touchdown(parameters: Any, memory: Any, q_before: Any, q: Any, dq: Any) -> Any:
    pass


def good_estimate(parameters: Any, memory: Any) -> Any:
    return math.nan


def good_break(parameters: Any, memory: Any, t: float) -> Any:
    return math.inf


def makes_array(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> Any:
    out[:2] = np.array([q[0], q[1]])


def makes_list(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> Any:
    numbers = [q[0], q[1]]
    numbers.append(t)
    out[0] = numbers[0]


def writes_text(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> Any:
    out[0] = "q2"


def misspelt(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> Any:
    out[0] = sine(q[0])  # type: ignore[name-defined]  # noqa: F821


def returning_pair(parameters: Any, memory: Any) -> Any:
    return 0.0, 0.0


GOOD = Law((1.0,), good_torque, good_touchdown, good_estimate, good_break)


def compiled(law: Law) -> MachineCode:
    class ByLaw(LawController):
        @property
        def plain_law(self) -> Law:
            return law

    return MachineCode(ByLaw(), law)


def test_good_laws_are_not_blamed() -> None:
    assert not compiled(GOOD).failed


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"torque": makes_array}, ["torque (makes_array): ", "test_compile_errors.py"]),
        ({"torque": makes_list}, ["torque (makes_list): it allocates memory", "of test_compile_errors.py"]),
        ({"torque": writes_text}, ["torque (writes_text): ", "test_compile_errors.py"]),
        ({"torque": misspelt}, ["torque (misspelt): NameError: name 'sine' is not defined"]),
        ({"slope_estimate": returning_pair}, ["slope_estimate (returning_pair) returns ", "expected a float"]),
        (
            {"next_discontinuity": returning_pair},
            ["next_discontinuity (returning_pair): ", "3 argument types given", "2 arguments"],
        ),
    ],
    ids=lambda value: next(iter(value.values())).__name__ if isinstance(value, dict) else "",
)
def test_the_law_to_blame_is_named(changed: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(LawError) as refused:
        compiled(GOOD._replace(**changed))
    assert all(word in str(refused.value) for word in ["the laws of ByLaw cannot be compiled: ", *words])


class Misspelt(Controller):
    """Its torque is sound, the law that it gives for compilation is not."""

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        return 0.0, 0.0

    def law(self) -> Law | None:
        return GOOD._replace(torque=misspelt)


class Without(Misspelt):
    def law(self) -> Law | None:
        return None


@pytest.mark.slow  # Numba looks at the whole engine before it gives up
@pytest.mark.compiled
def test_walk_refuses_before_it_begins_and_its_advice_helps() -> None:
    with pytest.raises(InputError, match=r"the laws of Misspelt cannot be compiled: torque .*'sine'.* return None"):
        mjbiped.walk(Misspelt(), Terrain.incline(2.0), engine="hybrid", steps=1)
    walk = mjbiped.walk(Without(), Terrain.incline(2.0), engine="hybrid", steps=1)
    assert walk.outcome == "finished"
