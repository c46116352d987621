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


@pytest.mark.slow  # the many take some five minutes each
@pytest.mark.timeout(1800)
@pytest.mark.parametrize(("engine", "seeds"), [("hybrid", FAST), ("mujoco", FAST), *SLOW])
def test_walks_are_possible(engine: str, seeds: range) -> None:
    outcomes = set()
    for seed in seeds:
        with within(LONGEST, (engine, seed)):
            walk = some_walk(seed, engine)
        if walk is not None:
            assert not list(faults(walk)), (engine, seed, walk)
            outcomes.add(walk.outcome)
    wanted = {"finished", "fell"} | ({"stalled"} if seeds == FAST else set())
    # of MuJoCo's no first seed diverges; tests/engines/mujoco/test_outcomes.py has a walk that does
    assert outcomes >= wanted | ({"diverged"} if seeds == FAST and engine == "hybrid" else set())
