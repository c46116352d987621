"""Walks of any robot on any ground under any controller from any start: each ends, in its time, in a possible record.

Every seed is a walk of `walk_cases`; most of a thousand are walked by `make test-slow` alone.
"""

import pytest
from time_limits import within
from walk_cases import faults, some_walk

LONGEST = 60.0
"""Processor time of one case, s: 4 s were measured, and a controller of a new kind compiles for up to 30."""

FAST = range(12)
SLOW = {"hybrid": range(len(FAST), 1000), "mujoco": range(len(FAST), 700)}
ENGINES = pytest.mark.parametrize("engine", ["hybrid", "mujoco"])


def all_possible(engine: str, seeds: range) -> set[str]:
    """Walk them all; returns the outcomes that there were."""
    outcomes = set()
    for seed in seeds:
        with within(LONGEST, (engine, seed)):
            walk = some_walk(seed, engine)
        if walk is not None:
            assert not list(faults(walk)), (engine, seed, walk)
            outcomes.add(walk.outcome)
    return outcomes


@pytest.mark.slow
@ENGINES
def test_walks_are_possible(engine: str) -> None:
    assert all_possible(engine, FAST) >= {"finished", "fell", "diverged"}


@pytest.mark.slow  # five minutes each, on a busy machine more than ten
@pytest.mark.timeout(1800)
@ENGINES
def test_many_walks_are_possible(engine: str) -> None:
    assert all_possible(engine, SLOW[engine]) >= {"finished", "fell", "diverged", "stalled"}


@pytest.mark.slow
@ENGINES
def test_walks_repeat_bit_by_bit(engine: str) -> None:
    for seed in FAST[:8]:
        assert some_walk(seed, engine) == some_walk(seed, engine)
