"""The hybrid engine against Drake's `CompassGait` and against diffrax: passive walks at the same measured accuracy.

    pip install -e '.[bench]'               (optional; mjbiped needs none of it)
    python -m scripts.benchmarks.peer_benchmark        (part of: make bench)

Where one of them is not installed, its table in docs/tables/performance.md stays as it is.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from functools import partial
from importlib.metadata import version
from importlib.util import find_spec

import click
import numpy as np
from numpy.typing import NDArray

import mjbiped
from controllers import PassiveController
from mjbiped.engines.plan import Plan, Terms
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.terrain import Terrain
from scripts.benchmarks.scipy_walk import ScipyWalk
from scripts.benchmarks.timing import PAGE, Case, interleaved
from scripts.pages import write_table

GOAL = 1e-9  # greatest error of the states at 20 touchdowns that counts as accurate, rad and rad/s
CHECKED = 20  # touchdowns
TOLERANCES = (1e-8, 1e-9, 1e-10, 1e-11, 1e-12)
HEADINGS = ("walked by", "error", "steps/s", "hybrid : it")


def start_of(robot: mjbiped.Compass, slope: float) -> NDArray[np.float64]:
    """A state beside the gait, feet on the ground: the walk comes back to the gait within some steps."""
    return np.asarray(mjbiped.find_passive_gait(robot, slope).start * np.array([1.0, 1.0, 1.0, 0.98]))


def exact_states(robot: mjbiped.Compass, slope: float) -> NDArray[np.float64]:
    """States after the first touchdowns by SciPy at 1e-13."""
    walk = ScipyWalk(PassiveController(), Terrain.incline(math.degrees(slope)), robot, tolerance=1e-13)
    return walk.states(start_of(robot, slope), CHECKED)


def hybrid_error(robot: mjbiped.Compass, slope: float) -> tuple[float, NDArray[np.float64]]:
    """Greatest error of the hybrid engine's states, and the times of its touchdowns."""
    ground = Terrain.incline(math.degrees(slope))
    touchdowns = mjbiped.walk(
        PassiveController(),
        ground,
        engine="hybrid",
        robot=robot,
        steps=CHECKED,
        initial=start_of(robot, slope).tolist(),
    ).touchdowns
    found = np.concatenate([touchdowns["q"], touchdowns["dq"]], axis=1)
    return float(np.abs(found - exact_states(robot, slope)).max()), touchdowns["time"]


def hybrid_case(robot: mjbiped.Compass, slope: float, steps: int) -> Case:
    """A walk of the hybrid engine, without what builds it and without samples."""
    start, engine = tuple(start_of(robot, slope).tolist()), mjbiped.Hybrid()

    def run() -> float:
        terms = Terms(engine, steps, None, robot, None, ScuffingRule())
        terrain = Terrain.incline(math.degrees(slope))
        walk = engine.start(Plan(terms, PassiveController(), terrain, robot, start[:2], start[2:], {}))
        started = time.thread_time()
        walk.go()
        return time.thread_time() - started

    return run


def accurate(error_at: Callable[[float], float]) -> tuple[float, float]:
    """The loosest tolerance that reaches the goal, and its error; the best one where none does."""
    found = []
    for tolerance in TOLERANCES:
        found.append((error_at(tolerance), tolerance))
        if found[-1][0] <= GOAL:
            break
    error, tolerance = min(found)
    return tolerance, error


def against_drake(repeats: int, steps: int) -> list[list[str]]:
    """Rows: the hybrid engine, and Drake's simulator with each of its integrators."""
    from scripts.benchmarks.drake_walk import INTEGRATORS, DrakeWalk, robot_and_slope

    robot, slope = robot_and_slope()
    start, exact = start_of(robot, slope), exact_states(robot, slope)
    own_error, times = hybrid_error(robot, slope)

    def error_of(integrator: str, accuracy: float) -> float:
        before = DrakeWalk(integrator, accuracy).touchdowns(start, times[-1] + 0.01)[:, :4]
        after = np.array([np.concatenate(robot.impact(state[:2], state[2:])) for state in before])
        return float(np.abs(after - exact).max())

    rows, cases = [], {"hybrid": (hybrid_case(robot, slope, steps), steps)}
    for integrator in INTEGRATORS:
        accuracy, error = accurate(partial(error_of, integrator))
        walk = DrakeWalk(integrator, accuracy)
        cases[integrator] = (partial(walk.timed, start, times[-1] + 1e-3), CHECKED)
        rows.append([f"Drake {version('drake')}, `{integrator}` at {accuracy:.0e}", f"{error:.1e}"])
    timings = interleaved(cases, repeats, "Drake")
    for row, integrator in zip(rows, INTEGRATORS, strict=True):
        row += [timings[integrator].rate, timings["hybrid"].ratio(timings[integrator])]
    return [["hybrid engine", f"{own_error:.1e}", timings["hybrid"].rate, ""], *rows]


def against_diffrax(repeats: int, steps: int) -> list[list[str]]:
    """Rows: the hybrid engine, and diffrax."""
    from scripts.benchmarks.diffrax_walk import DiffraxWalk

    robot, slope = mjbiped.Compass(), math.radians(2)
    start, exact = start_of(robot, slope), exact_states(robot, slope)
    own_error, _ = hybrid_error(robot, slope)

    def error_of(tolerance: float) -> float:
        return float(np.abs(DiffraxWalk(robot, slope, tolerance=tolerance, steps=CHECKED).states(start) - exact).max())

    tolerance, error = accurate(error_of)
    walk = DiffraxWalk(robot, slope, tolerance=tolerance, steps=steps)

    def run() -> float:
        started = time.process_time()  # JAX computes in a thread of its own
        walk.states(start)
        return time.process_time() - started

    timings = interleaved(
        {"hybrid": (hybrid_case(robot, slope, steps), steps), "diffrax": (run, steps)}, repeats, "diffrax"
    )
    hybrid, diffrax = timings["hybrid"], timings["diffrax"]
    name = f"diffrax {version('diffrax')}, JAX {version('jax')}, `Dopri8` at {tolerance:.0e}"
    return [
        ["hybrid engine", f"{own_error:.1e}", hybrid.rate, ""],
        [name, f"{error:.1e}", diffrax.rate, hybrid.ratio(diffrax)],
    ]


@click.command()
@click.option("--repeats", default=7, show_default=True, type=click.IntRange(3), help="Repetitions of each case.")
@click.option("--steps", default=2000, show_default=True, type=click.IntRange(60), help="Gait steps of a timed walk.")
def main(repeats: int, steps: int) -> None:
    """Measure, and write the tables of docs/tables/performance.md."""
    for module, name, measure in (
        ("pydrake", "drake", against_drake),
        ("diffrax", "diffrax", against_diffrax),
    ):
        if find_spec(module) is None:
            click.echo(f"{name} is not installed here: its table in {PAGE} stays as it is")
        else:
            write_table(PAGE, name, HEADINGS, measure(repeats, steps))


if __name__ == "__main__":
    main()
