"""The compass biped of Goswami, Thuilot and Espiau: its gait on 3 degrees in both engines, and its cascade."""

from __future__ import annotations

import math
from functools import cache, partial

import numpy as np

import mjbiped
from controllers import PassiveController
from mjbiped.gaits.passive import PassiveGait, find_passive_gait
from mjbiped.limit_cycles.bifurcation import FEIGENBAUM, Cascade, bifurcation_diagram, find_cascade
from mjbiped.limit_cycles.periodic import GUARD
from mjbiped.limit_cycles.return_map import ReturnMap
from mjbiped.robots.compass import Array
from scripts.validation.published import GOSWAMI_CHAOS, GOSWAMI_ROBOT, GOSWAMI_SLOPE, Computations, Computed

DOUBLINGS = 5
MUJOCO_STEPS = 40
LONGEST_PERIOD = 256
"""Of the periods that are looked for where the gait is said to be chaotic, steps."""
APART, PARTED = 1e-9, 1e-3
"""Distance of two walks at their start, and when they have parted, rad."""


@cache
def gait() -> PassiveGait:
    """The gait on 3 degrees."""
    return find_passive_gait(GOSWAMI_ROBOT, GOSWAMI_SLOPE)


@cache
def cascade() -> Cascade:
    """Its period doublings on steeper slopes."""
    return find_cascade(GOSWAMI_ROBOT, DOUBLINGS)


def _two_steps(index: int) -> Computed:
    return Computed(abs(gait().multipliers[index]) ** 2, 1e-6)


def _onset(index: int) -> Computed:
    return Computed(math.degrees(cascade().onsets[index]), 1e-6)


def _gathering() -> Computed:
    """Where the doublings gather; the error is what Feigenbaum's ratio of one doubling less would change."""
    degrees, end = np.degrees(cascade().onsets), math.degrees(cascade().accumulation)
    before = degrees[-2] + (degrees[-2] - degrees[-3]) / (FEIGENBAUM - 1)
    return Computed(end, abs(end - before))


GOSWAMIS: Computations = {
    "period": lambda: Computed(gait().period, 1e-12),
    "angle": lambda: Computed(gait().start[1], 1e-12),
    "stance rate": lambda: Computed(gait().start[2], 1e-12),
    "swing rate": lambda: Computed(gait().start[3], 1e-12),
    "pair": partial(_two_steps, 0),
    "real": partial(_two_steps, 2),
    "first doubling": partial(_onset, 0),
    "second doubling": partial(_onset, 1),
    "third doubling": partial(_onset, 2),
    "no period": _gathering,
}


@cache
def in_mujoco() -> Array:
    """Period, half angle and both rates just after the last of some impacts of a walk in MuJoCo, shape (4,)."""
    ground = mjbiped.Terrain.incline(math.degrees(GOSWAMI_SLOPE))
    walk = mjbiped.walk(PassiveController(), ground, robot=GOSWAMI_ROBOT, steps=MUJOCO_STEPS)
    rows = walk.touchdowns
    return np.array([np.diff(rows["time"])[-1], np.ptp(rows["q"][-1]) / 2, *rows["dq"][-1]])


@cache
def chaos() -> tuple[int, int]:
    """What the gait on 5.2 degrees does, reached from gentler slopes.

    Returns:
        The number of steps after which it repeats itself, of up to `LONGEST_PERIOD`, or 0; and the number of steps
        after which two walks that began `APART` from each other differ by `PARTED`.
    """
    slopes = np.linspace(math.radians(4.9), GOSWAMI_CHAOS, 7)
    diagram = bifurcation_diagram(GOSWAMI_ROBOT, slopes, steps=2000, keep=2 * LONGEST_PERIOD, scuffing=GUARD)
    last, steps = diagram.states[-1, -1], ReturnMap(GOSWAMI_ROBOT, GOSWAMI_CHAOS, GUARD)
    beside = last + APART * np.array([-1.0, 1.0, 0.0, 0.0])
    one, other = (steps.walk(start, 400).states[:, 0] for start in (last, beside))
    return int(diagram.counts()[-1]), int(np.argmax(np.abs(one - other) > PARTED))
