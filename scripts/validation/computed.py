"""What this laboratory computes where others have published a number."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple, TypeAlias


class Computed(NamedTuple):
    """A number of ours beside a published one.

    Attributes:
        value: In the unit and with the sign of the published number.
        error: How far it may be from the model's exact number: measured by a second way, or by a finer calculation.
        as_published: Where the published number has a fault: what comes of the calculation that explains it; None where
            none is known.
    """

    value: complex
    error: float
    as_published: complex | None = None


Computations: TypeAlias = Mapping[str, Callable[[], Computed]]
"""By the names of the published numbers."""
