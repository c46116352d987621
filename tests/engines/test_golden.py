"""Walks are what they were before the house was built anew; `scripts.golden_walks` made them."""

import golden_numbers
import golden_walks
import numpy as np
import pytest
from engines.conformance.cases import QUICK, name_of, parametrised, walk_of
from golden_walks import CASES, STEPS, Case

import mjbiped

IMPACTS = ("friction", "normal_force", "penetration", "pressure_ahead", "pressure_behind", "slap", "slip", "tipped")
"""Columns of forces and depths in single steps about an impact, which multiply what rounding differs by."""


def check(case: Case, walk: mjbiped.Walk) -> None:
    """A walk is the beginning of the stored one.

    Sums may be taken in another order: 1e-9 of a column's greatest number, 1e-7 where MuJoCo resolves an impact. What
    moves farther with the last bits of gravity, or with the gait that another processor finds, may move ten times as
    far as four samples of the one and three of the other have shown.
    """
    found, wanted = golden_walks.kept(walk), golden_walks.stored(case)
    if walk.steps == STEPS:
        assert found["outcome"] == wanted["outcome"]
    whole = walk.steps == len(wanted["touchdowns time"])
    sampled = len(found["samples time"]) if whole else int(np.sum(found["samples time"] < walk.touchdowns["time"][-1]))
    for name, column in wanted.items():
        if name == "outcome" or name.startswith("moved"):
            continue
        # a controller with a period of its own takes notice of the last touchdown in the step after it
        noticed = walk.steps - (case.disturbed and not whole)
        rows = noticed if name.startswith("touchdowns") else sampled
        here, there = found[name][:rows], column[:rows] if not whole else column
        if column.dtype.kind != "f":
            np.testing.assert_array_equal(here, there, err_msg=name)
            continue
        sensitive = case.engine != "hybrid" and name.split()[-1] in IMPACTS
        scale = max(np.abs(column).max(initial=0.0, where=np.isfinite(column)), 1e-3)
        allowed = max((1e-7 if sensitive else 1e-9) * scale, 10.0 * float(wanted[f"moved {name}"]))
        np.testing.assert_allclose(here, there, rtol=0.0, atol=allowed, err_msg=name)


@parametrised(QUICK)
def test_a_walk_begins_as_it_did(case: Case) -> None:
    check(case, walk_of(case))
    golden_numbers.check(f"walk {name_of(case)}")


@pytest.mark.slow
@pytest.mark.compiled
@parametrised(CASES)
def test_a_walk_is_what_it_was(case: Case) -> None:
    check(case, golden_walks.walked(case))
