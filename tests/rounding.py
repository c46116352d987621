"""Numbers that are the same but for rounding, of whatever size."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def assert_same(found: ArrayLike, expected: ArrayLike, accuracy: float, what: str = "") -> None:
    """Check that numbers agree, as an integration's tolerance has it: relative and absolute, of their column's size.

    A column's size counts, not each number's, for one that comes out near zero is the difference of others.

    Args:
        found: Columns, the last dimension being one row's.
        expected: The same shape.
        accuracy: Greatest difference, over one and the column's greatest number.
        what: Shown where they do not agree.
    """
    wanted = np.asarray(expected)
    size = 1.0 + np.abs(wanted).max(axis=0, initial=0.0)
    np.testing.assert_allclose(np.asarray(found) / size, wanted / size, rtol=0.0, atol=accuracy, err_msg=what)
