"""Benchmarks of the hybrid engine against Drake's `CompassGait` and diffrax: passive walks at equal measured accuracy.

Both are optional: `pip install -e '.[bench]'`.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from functools import partial
from importlib.metadata import version

import numpy as np
from numpy.typing import NDArray

import mjbiped
from controllers import PassiveController
from mjbiped.terrain.terrain import Terrain
from scripts.benchmarks.hybrid import CHECKED, ROBOT, Walked
from scripts.benchmarks.timing import Rows, interleaved

GOAL = 1e-9  # greatest error of the states at 20 touchdowns that counts as accurate, rad and rad/s
STEPS = 2000  # of a timed walk
TOLERANCES = (1e-8, 1e-9, 1e-10, 1e-11, 1e-12)


def start_of(robot: mjbiped.Compass, slope: float) -> NDArray[np.float64]:
    """A state beside the gait, feet on the ground: the walk comes back to the gait within some steps."""
    return np.asarray(mjbiped.find_passive_gait(robot, slope).start * np.array([1.0, 1.0, 1.0, 0.98]))


def accurate(error_at: Callable[[float], float]) -> tuple[float, float]:
    """The loosest tolerance that reaches the goal, and its error; the best one where none does."""
    found = []
    for tolerance in TOLERANCES:
        found.append((error_at(tolerance), tolerance))
        if found[-1][0] <= GOAL:
            break
    error, tolerance = min(found)
    return tolerance, error


def against_drake(repeats: int) -> Rows:
    """Rows: the hybrid engine, and Drake's simulator with each of its integrators."""
    from scripts.benchmarks.drake_walk import INTEGRATORS, DrakeWalk, robot_and_slope

    robot, slope = robot_and_slope()
    start, walked = start_of(robot, slope), Walked(PassiveController(), Terrain.incline(math.degrees(slope)), robot)
    exact, times = walked.exact(start), walked.touchdowns(start)["time"]

    def error_of(integrator: str, accuracy: float) -> float:
        before = DrakeWalk(integrator, accuracy).touchdowns(start, times[-1] + 0.01)[:, :4]
        after = np.array([np.concatenate(robot.impact(state[:2], state[2:])) for state in before])
        return float(np.abs(after - exact).max())

    rows, cases = [], {"hybrid": (walked.case(STEPS, start=start), STEPS)}
    for integrator in INTEGRATORS:
        accuracy, error = accurate(partial(error_of, integrator))
        walk = DrakeWalk(integrator, accuracy)
        cases[integrator] = (partial(walk.timed, start, times[-1] + 1e-3), CHECKED)
        rows.append([f"Drake {version('drake')}, `{integrator}` at {accuracy:.0e}", f"{error:.1e}"])
    timings = interleaved(cases, repeats, "Drake")
    for row, integrator in zip(rows, INTEGRATORS, strict=True):
        row += [timings[integrator].rate, timings["hybrid"].ratio(timings[integrator])]
    return [["hybrid engine", f"{np.abs(walked.states(start) - exact).max():.1e}", timings["hybrid"].rate, ""], *rows]


def against_diffrax(repeats: int) -> Rows:
    """Rows: the hybrid engine, and diffrax."""
    from scripts.benchmarks.diffrax_walk import DiffraxWalk

    slope = math.radians(2)
    start, walked = start_of(ROBOT, slope), Walked(PassiveController(), Terrain.incline(2.0))
    exact = walked.exact(start)

    def error_of(tolerance: float) -> float:
        return float(np.abs(DiffraxWalk(ROBOT, slope, tolerance=tolerance, steps=CHECKED).states(start) - exact).max())

    tolerance, error = accurate(error_of)
    walk = DiffraxWalk(ROBOT, slope, tolerance=tolerance, steps=STEPS)

    def run() -> float:
        started = time.process_time()  # JAX computes in a thread of its own
        walk.states(start)
        return time.process_time() - started

    timings = interleaved(
        {"hybrid": (walked.case(STEPS, start=start), STEPS), "diffrax": (run, STEPS)}, repeats, "diffrax"
    )
    hybrid, diffrax = timings["hybrid"], timings["diffrax"]
    name = f"diffrax {version('diffrax')}, JAX {version('jax')}, `Dopri8` at {tolerance:.0e}"
    return [
        ["hybrid engine", f"{np.abs(walked.states(start) - exact).max():.1e}", hybrid.rate, ""],
        [name, f"{error:.1e}", diffrax.rate, hybrid.ratio(diffrax)],
    ]
