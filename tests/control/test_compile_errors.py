"""Laws that cannot be compiled are refused before the walk, in words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

import mjbiped
from controllers import Controller
from mjbiped.control import compile_errors
from mjbiped.control.controller import Law, Memory
from mjbiped.errors import InputError
from mjbiped.terrain.terrain import Terrain


def good_torque(parameters: Any, memory: Any, t: float, q1: float, q2: float, dq1: float, dq2: float) -> Any:
    return 0.0, 0


def good_touchdown(
    parameters: Any, memory: Any, b1: float, b2: float, q1: float, q2: float, dq1: float, dq2: float
) -> Any:
    pass


def good_estimate(parameters: Any, memory: Any) -> Any:
    return math.nan


def good_break(parameters: Any, memory: Any, t: float) -> Any:
    return math.inf


def returns_array(parameters: Any, memory: Any, t: float, q1: float, q2: float, dq1: float, dq2: float) -> Any:
    return np.array([q1, q2])


def returns_list(parameters: Any, memory: Any, t: float, q1: float, q2: float, dq1: float, dq2: float) -> Any:
    return [q1, q2]


def returns_three(parameters: Any, memory: Any, t: float, q1: float, q2: float, dq1: float, dq2: float) -> Any:
    return q1, q2, t


def returns_one(parameters: Any, memory: Any, t: float, q1: float, q2: float, dq1: float, dq2: float) -> Any:
    return q1


def returns_text(parameters: Any, memory: Any, t: float, q1: float, q2: float, dq1: float, dq2: float) -> Any:
    return q1, "q2"


def misspelt(parameters: Any, memory: Any, t: float, q1: float, q2: float, dq1: float, dq2: float) -> Any:
    return sine(q1), 0.0  # type: ignore[name-defined]  # noqa: F821


def returning_touchdown(
    parameters: Any, memory: Any, b1: float, b2: float, q1: float, q2: float, dq1: float, dq2: float
) -> Any:
    return q1


def returning_pair(parameters: Any, memory: Any) -> Any:
    return 0.0, 0.0


def any_number(parameters: Any, memory: Any, *state: float) -> Any:
    return None


def returning_state(parameters: Any, memory: Any, t: float, *state: float) -> Any:
    return state


GOOD = Law((1.0,), good_torque, good_touchdown, good_estimate, good_break)


def test_good_laws_are_not_blamed() -> None:
    assert compile_errors._blame(GOOD, ()) == ""
    assert compile_errors._blame(GOOD._replace(touchdown=any_number), ()) == ""


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"parameters": {"k": 1.0}}, ["parameters are {'k': 1.0}", "numbers, arrays, tuples and NamedTuples"]),
        ({"torque": returns_array}, ["torque (returns_array): ", "test_compile_errors.py"]),
        ({"torque": returns_list}, ["torque (returns_list): it allocates memory", "of test_compile_errors.py"]),
        (
            {"torque": returns_three},
            ["torque (returns_three) returns UniTuple(float64 x 3); expected a tuple of 2 floats"],
        ),
        ({"torque": returning_state}, ["torque (returning_state) returns ", "expected a tuple of 2 floats"]),
        ({"torque": returns_one}, ["torque (returns_one) returns float64; expected a tuple of 2 floats"]),
        ({"torque": returns_text}, ["torque (returns_text) returns ", "expected a tuple of 2 floats"]),
        ({"torque": misspelt}, ["torque (misspelt): NameError: name 'sine' is not defined"]),
        ({"touchdown": returning_touchdown}, ["touchdown (returning_touchdown) returns float64; expected nothing"]),
        ({"slope_estimate": returning_pair}, ["slope_estimate (returning_pair) returns ", "expected a float"]),
        (
            {"next_discontinuity": returning_pair},
            ["next_discontinuity (returning_pair): ", "3 argument types given", "2 arguments"],
        ),
    ],
    ids=lambda value: (
        next(iter(value.values())).__name__ if isinstance(value, dict) and callable(next(iter(value.values()))) else ""
    ),
)
def test_the_law_to_blame_is_named(changed: dict[str, Any], words: list[str]) -> None:
    blame = compile_errors._blame(GOOD._replace(**changed), ())
    assert all(word in blame for word in words), blame


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
