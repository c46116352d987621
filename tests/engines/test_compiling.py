"""Which walks are interpreted and which compile, and that nothing in a walk tells which way it ran."""

import dataclasses
from pathlib import Path
from typing import Any

import pytest
from command_line import python

from controllers import AdaptiveController, Controller, Law, PassiveController
from mjbiped import InputError, Terrain
from mjbiped.engines import compiling
from mjbiped.engines.base import engine_of
from mjbiped.engines.compiling import compiles, missing, note_kept
from mjbiped.engines.plan import Plan, Terms, make_plan
from mjbiped.numerics import cache
from mjbiped.rules.scuffing import ScuffingRule

ENGINES = ("hybrid", "mujoco")


@pytest.fixture(autouse=True)
def empty_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Neither the disk nor this process has machine code yet, and nobody has overruled the rule."""
    monkeypatch.delenv(compiling.VARIABLE, raising=False)
    monkeypatch.setattr(cache, "_folder", lambda: tmp_path)


def planned(controller: Controller, engine: str, steps: Any = None, distance: Any = None, walks: int = 1) -> Plan:
    terms = Terms(engine_of(engine), steps, distance, None, None, ScuffingRule(), walks)
    return make_plan(terms, controller, Terrain.incline(2.0), "gait")


@pytest.mark.parametrize("engine", ENGINES)
def test_the_default_walk_is_interpreted_and_a_long_one_compiles(engine: str, controller: Controller) -> None:
    assert not compiles(planned(controller, engine))
    assert compiles(planned(controller, engine, steps=100_000))
    assert compiles(planned(controller, engine, distance=100_000.0))
    assert compiles(planned(controller, engine, steps=1, walks=10_000))
    of_unknown_length = planned(controller, engine)
    cost = missing(of_unknown_length)
    assert [compiles(of_unknown_length, share * cost) for share in (0.9, 1.1)] == [False, True]


@pytest.mark.parametrize("engine", ENGINES)
def test_what_is_on_disk_is_used_however_short_the_walk(engine: str, controller: AdaptiveController) -> None:
    plan = planned(controller, engine, steps=1)
    assert not compiles(plan)
    note_kept(plan)
    assert compiles(plan)
    assert compiles(planned(dataclasses.replace(controller, position_gain=7.0), engine, steps=1))
    other = planned(PassiveController(), engine, steps=1)
    assert not compiles(other)  # whose laws are others
    assert 0.0 < missing(other) < missing(plan) + 1e3


@pytest.mark.parametrize("engine", ENGINES)
def test_the_environment_overrules(engine: str, controller: Controller, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(compiling.VARIABLE, "always")
    assert compiles(planned(controller, engine, steps=1))
    monkeypatch.setenv(compiling.VARIABLE, "never")
    assert not compiles(planned(controller, engine, steps=100_000))
    monkeypatch.setenv(compiling.VARIABLE, "sometimes")
    with pytest.raises(InputError, match="MJBIPED_COMPILE = 'sometimes': expected always, never or auto"):
        compiles(planned(controller, engine))


def cubed(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> None:
    out[0], out[1] = 0.0, -((q[1] - q[0]) ** 3)


class Own(PassiveController):
    """A law of one's own."""

    def law(self) -> Law:
        return super().law()._replace(torque=cubed)


def test_a_law_with_powers_is_never_interpreted() -> None:
    """x**3 is one call of C's pow in Python and two products in machine code, which round differently."""
    assert compiles(planned(Own(), "hybrid", steps=1))


FIRST_WALK = """
import sys
import mjbiped
from controllers import PassiveController
for engine in "hybrid", "mujoco":
    mjbiped.walk(PassiveController(), mjbiped.Terrain.incline(2.0), engine=engine, steps=2)
print("numba" in sys.modules)
"""


def test_a_first_walk_does_not_load_the_compiler(tmp_path: Path) -> None:
    done = python("-c", FIRST_WALK, cwd=tmp_path, NUMBA_CACHE_DIR=str(tmp_path), **{compiling.VARIABLE: "auto"})
    assert (done.stdout, done.stderr) == ("False\n", "")
