"""Walks of any robot on any ground under any controller from any start: each ends, in its time, in a possible record.

Every seed is a walk of `walk_cases`; most of a thousand are walked by `make test-slow` alone.
"""

import pytest
from time_limits import within
from walk_cases import faults, some_walk

LONGEST = 60.0
"""Processor time of one case, s: a search for a gait that there is none of takes up to 30, as does compiling a law."""

FAST = range(30)
SLOW = [
    *(("hybrid", range(first, first + 243)) for first in range(len(FAST), 1000, 243)),
    *(("mujoco", range(first, first + 335)) for first in range(len(FAST), 700, 335)),
]
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
    assert all_possible(engine, FAST) >= {"finished", "fell", "diverged", "stalled"}


@pytest.mark.slow  # some five minutes each
@pytest.mark.timeout(1800)
@pytest.mark.parametrize(("engine", "seeds"), SLOW)
def test_many_walks_are_possible(engine: str, seeds: range) -> None:
    assert all_possible(engine, seeds) >= {"finished", "fell"}


@pytest.mark.slow
@ENGINES
def test_walks_repeat_bit_by_bit(engine: str) -> None:
    for seed in FAST[:8]:
        assert some_walk(seed, engine) == some_walk(seed, engine)
