"""Walks are what they were before the house was built anew; `python tests/golden_walks.py` made them."""

from __future__ import annotations

import golden_walks
import numpy as np
import pytest
from golden_walks import CASES, Case

QUICK = {Case("compass", "adaptive", "mixed", engine, True) for engine in golden_walks.BOTH}
IMPACTS = ("friction", "normal_force", "penetration", "pressure_ahead", "pressure_behind", "slap", "slip", "tipped")
"""Columns of forces and depths in single steps about an impact, which multiply what rounding differs by."""


@pytest.mark.compiled
@pytest.mark.parametrize(
    "case",
    [
        pytest.param(case, marks=() if case in QUICK else pytest.mark.slow, id="-".join(map(str, case)))
        for case in CASES
    ],
)
def test_a_walk_is_what_it_was(case: Case) -> None:
    """Sums may be taken in another order: 1e-9 of a column's greatest number, 1e-7 where MuJoCo resolves an impact.

    What moves farther with the last bits of gravity may move ten times as far as four samples of those have shown.
    """
    found, wanted = golden_walks.kept(golden_walks.walked(case)), golden_walks.stored(case)
    for name, column in wanted.items():
        if name.startswith("moved"):
            continue
        if column.dtype.kind != "f":
            np.testing.assert_array_equal(found[name], column, err_msg=name)
            continue
        sensitive = case.engine != "hybrid" and name.split()[-1] in IMPACTS
        scale = max(np.abs(column).max(initial=0.0, where=np.isfinite(column)), 1e-3)
        allowed = max((1e-7 if sensitive else 1e-9) * scale, 10.0 * float(wanted[f"moved {name}"]))
        np.testing.assert_allclose(found[name], column, rtol=0.0, atol=allowed, err_msg=name)
