"""The table of conformance: the golden walks, of which the first steps are put to all oracles, and what they share."""

from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any, NamedTuple

import golden_walks
import numpy as np
import pytest
from engines.conformance.free_bodies import Array, FreeRobot
from golden_walks import CASES, ROBOTS, Case

import mjbiped

FEET = ("footed", "boxes")
"""Robots whose feet are bodies: MuJoCo steps them by 0.1 ms."""
DEAR = ("sole supervised", "footed supervised", "kneed on soles bounded-ankle", "heavy hip adaptive")
"""Robots and laws whose gaits take seconds to find: they are walked by the slow tests."""
IN_MUJOCO = {
    *(("compass", "adaptive", ground) for ground in ("3 up", "downstairs", "riser", "breaks")),
    *(("compass", law, ground) for law, ground in (("passive", "3 down"), ("policy", "level"))),
    *(("kneed", "adaptive", ground) for ground in ("upstairs", "early riser")),
}
"""In MuJoCo a step takes ten times as long: of these two robots' walks few are quick, of others all."""


def is_quick(case: Case) -> bool:
    """Whether the default tests walk a case, some steps of it in plain Python."""
    if f"{case.robot} {case.law}" in DEAR:
        return False
    few = case.engine == "mujoco" and not case.disturbed and case.robot in ("compass", "kneed")
    return not few or case[:3] in IN_MUJOCO


QUICK = [case for case in CASES if is_quick(case)]
UNDISTURBED = [case for case in QUICK if not case.disturbed]


def steps_of(case: Case) -> int:
    """How many steps of a case are walked: in MuJoCo few, and one in physics steps of 0.1 ms."""
    if case.engine == "hybrid":
        return 6
    return 1 if case.robot in FEET or case.engine == "plain" else 3


def contact_step(case: Case) -> float:
    """Length of the physics step in which MuJoCo resolves an impact, s."""
    return 1e-4 if case.robot in FEET or case.engine == "plain" else 1e-5


def softness(case: Case) -> float:
    """How much more MuJoCo's impacts leave than a contact step's motion: locks of bent knees and McGeer's give more."""
    return 10.0 if case.robot == "round kneed" else 3.0 if case.ground == "early riser" else 1.0


@cache
def walk_of(case: Case) -> mjbiped.Walk:
    return golden_walks.walked(case, steps=steps_of(case))


@cache
def dense_walk_of(case: Case) -> mjbiped.Walk:
    """The first steps of a case with a sample every 0.5 ms."""
    return golden_walks.walked(case, steps=3, sample_period=5e-4)


@cache
def bodies_of(robot: str) -> FreeRobot:
    return FreeRobot(ROBOTS[robot])


def name_of(case: Case) -> str:
    return "-".join(map(str, case[:4]))


def parametrised(cases: Sequence[Case]) -> pytest.MarkDecorator:
    """Each case is a test of its name."""
    return pytest.mark.parametrize("case", [pytest.param(case, id=name_of(case)) for case in cases])


BEGINS = ("qpos", "stance", "slope", "q", "dq")
KNEE = ("knee_dq_before", "knee_dq")


class Step(NamedTuple):
    """A gait step: posture and rates when it begins, before and after its knee strike, and before and after its end.

    Attributes:
        row: Of the touchdown that ends it.
        stance: Its stance leg.
        slope: Of the ground under it, rad.
        begin: Posture and rates after the impact that began it.
        knee: Posture, and rates before and after the swing knee's strike; None without one.
        end: Posture and rates before the impact that ends it.
        after: Posture and rates after that.
    """

    row: int
    stance: int
    slope: float
    begin: tuple[Array, Array]
    knee: tuple[Array, Array, Array] | None
    end: tuple[Array, Array]
    after: tuple[Array, Array]


def steps_in(walk: mjbiped.Walk, bodies: FreeRobot) -> Iterator[Step]:
    """The steps of a walk, their rates being those of the free bodies."""
    rows, robot = walk.touchdowns, walk.robot
    first: dict[str, Any] = {name: walk.samples[name][0] for name in BEGINS}
    for row in range(walk.steps):
        stance, slope, qpos = int(first["stance"]), float(first["slope"]), first["qpos"]
        begin = qpos, bodies.rates(qpos, stance, first["dq"], slope)
        last = rows["qpos"][row]
        knee = None
        if "knee_q" in rows and np.isfinite(rows["knee_q"][row]).all():
            angles = rows["knee_q"][row] + slope
            bent = float(robot.flexion(qpos, stance))
            rolled = bodies.radius * (rows["knee_q"][row][0] - first["q"][0]) * np.exp(-1j * slope)
            centre = bodies.ends[stance].place(qpos) + rolled
            struck = np.array(robot.posture((centre.real, centre.imag), stance, angles, bent, slope))
            free, locked = (bodies.rates(struck, stance, rows[name][row], slope) for name in KNEE)
            knee = struck, free, locked
        end = last, bodies.rates(last, stance, rows["dq_before"][row], slope)
        first = {name: rows[name][row] for name in BEGINS}
        after = last, bodies.rates(last, int(first["stance"]), first["dq"], float(first["slope"]))
        yield Step(row, stance, slope, begin, knee, end, after)
