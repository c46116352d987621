"""Laws of scalars, the form of `Law` of the last release: they still walk, and say how to write them now."""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest

import mjbiped
from controllers import Controller, Law, LawController, Memory, never
from mjbiped.control import scalar_laws
from mjbiped.control.compiled import compilable_law
from mjbiped.control.scalar_laws import takes_scalars


def spring(parameters: Any, memory: Memory, t: float, q1: float, q2: float, dq1: float, dq2: float) -> Any:
    stiffness, spread = parameters
    return 0.0, -stiffness * (q2 - q1 - spread)


def any_state(parameters: Any, memory: Memory, t: float, *state: float) -> Any:
    return spring(parameters, memory, t, *state)


def nothing(parameters: Any, memory: Memory, b1: float, b2: float, q1: float, q2: float, dq1: float, dq2: float) -> Any:
    pass


def unknown(parameters: Any, memory: Memory) -> float:
    return math.nan


def on_arrays(parameters: Any, memory: Memory, t: float, q: Any, dq: Any, out: Any) -> None:
    out[0], out[1] = 0.0, -parameters[0] * (q[1] - q[0] - parameters[1])


def quiet(parameters: Any, memory: Memory, q_before: Any, q: Any, dq: Any) -> None:
    pass


OLD: Any = Law((0.5, 0.4), spring, nothing, unknown, never)
NEW = Law((0.5, 0.4), on_arrays, quiet, unknown, never)


class ByLaw(LawController):
    def __init__(self, law: Law) -> None:
        self.given = law

    @property
    def plain_law(self) -> Law:
        return self.given


class ByMethods(Controller):
    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        values: Sequence[float] = spring((0.5, 0.4), memory, t, *q, *dq)
        return values

    def law(self) -> Law:
        law: Law = OLD
        return law


@pytest.fixture(autouse=True)
def warned_anew() -> None:
    scalar_laws._warn.cache_clear()


def test_the_two_forms_are_told_apart() -> None:
    assert takes_scalars(spring)
    assert takes_scalars(any_state)
    assert not takes_scalars(on_arrays)


@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
@pytest.mark.parametrize(
    "controller",
    [
        lambda: ByLaw(OLD),
        ByMethods,
        lambda: ByLaw(OLD._replace(torque=any_state)),
    ],
)
def test_it_walks_as_the_law_on_arrays_and_says_how_to_write_that(
    controller: Callable[[], Controller], engine: str
) -> None:
    given: dict[str, Any] = {"engine": engine, "steps": 1, "initial": (-0.19, 0.19, 1.1, 0.81)}
    with pytest.warns(DeprecationWarning, match=r"def torque\(parameters, memory, t, q, dq, out\): out\[0\], out\[1\]"):
        old = mjbiped.walk(controller(), mjbiped.Terrain.incline(2.0), **given)
    new = mjbiped.walk(ByLaw(NEW), mjbiped.Terrain.incline(2.0), **given)
    assert np.abs(new.samples["torque"]).max() > 0.0
    np.testing.assert_array_equal(old.samples["torque"], new.samples["torque"])


def test_it_is_interpreted() -> None:
    assert compilable_law(ByLaw(NEW)) is NEW
    with pytest.warns(DeprecationWarning, match="is interpreted"):
        assert compilable_law(ByLaw(OLD)) is None


def test_it_can_be_sent_to_other_processes() -> None:
    controller = ByLaw(OLD)
    with pytest.warns(DeprecationWarning, match="law of scalars"):
        values = controller.torque([], 0.0, (0.1, 0.2), (0.0, 0.0))
    assert pickle.loads(pickle.dumps(controller)).torque([], 0.0, (0.1, 0.2), (0.0, 0.0)) == values
