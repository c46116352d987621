"""Gaits of their descriptions in records."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mjbiped.gaits.gait import Gait
from mjbiped.gaits.optimised import optimised_from
from mjbiped.gaits.passive import find_passive_gait
from mjbiped.robots.compass import Compass


def gait_from(described: Mapping[str, Any]) -> Gait:
    """The gait that `Gait.describe` described: a passive one is found anew, an optimised one is read.

    Raises:
        KeyError: Something is missing.
        TypeError: Something is of another kind.
        InputError: A number is outside its domain.
        GaitError: The passive gait is not found.
    """
    if "goal" in described:
        return optimised_from(described)  # type: ignore[return-value]  # with knees, for readers who expect them
    return find_passive_gait(Compass(**described["robot"]), described["slope"])
