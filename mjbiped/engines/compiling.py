"""Whether a walk is interpreted or runs as machine code: one rule for all walks.

A walk is interpreted unless its machine code is on disk already, or interpreting all its steps would take longer than
compiling does. Both ways make the same walk, bit for bit. The environment variable `MJBIPED_COMPILE` overrules it:
"always" compiles every walk that can be compiled, "never" compiles none.
"""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from mjbiped.control.compiled import compilable_law, rounds_alike
from mjbiped.control.controller import Controller
from mjbiped.errors import InputError, shown
from mjbiped.numerics import cache as disk
from mjbiped.numerics.cache import announced, described, with_callees

if TYPE_CHECKING:
    from mjbiped.engines.plan import Plan

VARIABLE = "MJBIPED_COMPILE"
AHEAD: ContextVar[int] = ContextVar("walks ahead", default=1)
"""Number of walks of the study that is under way in this process; 1: none is."""
_ALWAYS, _NEVER, _AUTO = "always", "never", "auto"
_SHORTEST_GAIT_STEP = 0.3  # leg lengths: the walk of a distance has at most so many steps
_SOURCES = (
    *("control", "controllers", "disturbances", "dynamics", "engines", "numerics"),
    *("records", "robots", "rules", "terrain"),
)
_MOMENT = 5.0  # time for which many walks are interpreted one after another, s
LAW = 4.0  # CPU time for compiling a controller's laws, s


class Costs(NamedTuple):
    """What the two ways cost on one core, s of CPU; docs/hybrid.md has the measurement.

    Attributes:
        engine: Compiling the engine for a robot, the laws of the controller not included.
        step: Interpreting a gait step, with a sample each 5 ms.
    """

    engine: float
    step: float


def compiles(plan: Plan, interpreted: float | None = None) -> bool:
    """Whether a walk is to run as machine code.

    Args:
        plan: The walk.
        interpreted: Of walks whose lengths nobody knows, such as a learner's episodes: time that was spent on
            interpreting them so far, s. None: the length of this one and the number of its kind decide.

    Raises:
        InputError: `MJBIPED_COMPILE` is set to an unknown word.
    """
    choice = _choice()
    costs = plan.terms.engine.costs(plan.robot)
    if choice == _NEVER or costs is None:
        return False
    if choice == _ALWAYS:
        return True
    law = compilable_law(innermost(plan.driver))
    if law is not None and not rounds_alike(law):
        return True
    walks = plan.terms.walks
    time = walks * steps_of(plan) * costs.step if interpreted is None else interpreted
    if walks > 1 and time > _MOMENT:  # threads share all cores then
        return True
    return time > costs.engine + LAW or time > missing(plan)


def can_compile(plan: Plan) -> bool:
    """Whether machine code may and can be made of a walk's laws."""
    return _choice() != _NEVER and compilable_law(innermost(plan.driver)) is not None


def missing(plan: Plan) -> float:
    """CPU time for compiling what the disk does not have of a walk's machine code, s; 0: it has everything."""
    costs = plan.terms.engine.costs(plan.robot)
    assert costs is not None  # the engine has machine code
    times = (costs.engine, LAW)
    return sum(time for time, key in zip(times, _keys(plan), strict=True) if key and not disk.is_kept(key))


def note_kept(plan: Plan) -> None:
    """Note that the machine code of a walk is on disk now."""
    for key in _keys(plan):
        if key:
            disk.note_kept(key)


@contextmanager
def announced_for(plan: Plan) -> Iterator[None]:
    """Compile a walk's machine code in a block, which says so first, and note that it is there."""
    with announced(f"{type(plan.controller).__name__} for the engine {plan.terms.engine.name}", missing(plan)):
        yield
    note_kept(plan)


def steps_of(plan: Plan) -> float:
    """Number of touchdowns of a walk, at most."""
    steps, distance = plan.terms.steps, plan.terms.distance
    by_distance = math.inf if distance is None else distance / (_SHORTEST_GAIT_STEP * plan.robot.leg_length)
    return min(math.inf if steps is None else steps, by_distance)


def innermost(controller: Controller) -> Controller:
    """The controller itself, within a disturbed loop and within what an environment adds."""
    inner: Controller | None = getattr(controller, "inner", None)
    return controller if inner is None else innermost(inner)


def _choice() -> str:
    choice = os.environ.get(VARIABLE, _AUTO)
    if choice not in (_ALWAYS, _NEVER, _AUTO):
        raise InputError(f"{VARIABLE} = {shown(choice)}: expected {_ALWAYS}, {_NEVER} or {_AUTO}")
    return choice


def _keys(plan: Plan) -> tuple[str, str]:
    """Names under which the engine's machine code and that of the laws are noted; empty where there is none."""
    law, wrappers = compilable_law(innermost(plan.driver)), (type(plan.driver).__name__, plan.disturbances.in_loop)
    wanted = "" if law is None else _law_key(law[1:], wrappers)
    return _digest(_sources(), plan.terms.engine.name), wanted


@lru_cache(maxsize=256)
def _law_key(functions: tuple[object, ...], wrappers: object) -> str:
    return _digest(_sources(), [described(part) for part in with_callees(*functions)], wrappers)


@cache
def _sources() -> str:
    """Digest of all sources that machine code is made of."""
    here = Path(__file__).parents[1]
    files = sorted(file for name in _SOURCES for file in (here / name).rglob("*.py"))
    return _digest(*(file.read_bytes() for file in files))


def _digest(*parts: object) -> str:
    return hashlib.sha256(repr(parts).encode()).hexdigest()
