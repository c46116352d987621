"""Measure how fast mjbiped is, and write the results into docs/tables/performance.md.

python -m scripts.benchmarks                      (all of them, some seventeen minutes; or: make bench)
python -m scripts.benchmarks startup frames       (these two)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from pkgutil import resolve_name
from typing import NamedTuple

import click

from mjbiped.errors import RenderError
from scripts.benchmarks.timing import Rows
from scripts.pages import show_table

PAGE = Path("docs/tables/performance.md")
MANY_SEGMENTS = ("10", "100", "1,000", "10,000", "100,000")
PEERS = ("walked by", "error", "steps/s", "hybrid : it")


class Benchmark(NamedTuple):
    """One table of the page.

    Attributes:
        what: What is measured, for the list of benchmarks.
        headings: Headings of the table's columns.
        how: The function that returns the rows for a number of repetitions, as "module:name" in this package; a module
            is imported when it is used, since some need packages that are not always installed.
        repeats: Repetitions of each case unless others are asked for.
    """

    what: str
    headings: Sequence[str]
    how: str
    repeats: int = 11

    @property
    def measure(self) -> Callable[[int], Rows]:
        """The function that measures."""
        function: Callable[[int], Rows] = resolve_name(f"scripts.benchmarks.{self.how}")
        return function


BENCHMARKS = {
    "machine": Benchmark("the machine, its load and versions", ("", ""), "timing:machine"),
    "scipy": Benchmark(
        "hybrid engine and solve_ivp at the same accuracy",
        (
            "walk",
            "error, hybrid",
            "error, SciPy",
            "steps/s, hybrid",
            "with samples",
            "steps/s, SciPy",
            "hybrid : SciPy",
        ),
        "hybrid:against_scipy",
    ),
    "drake": Benchmark("hybrid engine and Drake at the same accuracy", PEERS, "peers:against_drake", 7),
    "diffrax": Benchmark("hybrid engine and diffrax at the same accuracy", PEERS, "peers:against_diffrax", 7),
    "steps": Benchmark(
        "time per gait step over the length of the walk",
        ("µs per gait step at so many steps", "100", "1,000", "10,000", "100,000"),
        "hybrid:over_steps",
    ),
    "segments": Benchmark(
        "time per gait step over the length of the ground",
        ("µs per gait step at so many segments", *MANY_SEGMENTS),
        "hybrid:over_segments",
    ),
    "threads": Benchmark(
        "two walks side by side", ("walk", "steps/s, 1 thread", "2 threads", "ratio"), "hybrid:over_threads", 22
    ),
    "plain python": Benchmark(
        "controllers that cannot be compiled",
        ("walk", "engine", "compiled, ms per gait step", "plain Python, ms per gait step", "times as fast"),
        "plain_python:against_compiled",
        9,
    ),
    "callbacks": Benchmark(
        "controller and contact events in a MuJoCo step",
        (
            "walk",
            "bare `mj_step`, µs",
            "compiled callbacks, µs",
            "compiled : bare",
            "Python callbacks, µs",
            "Python : bare",
            "`walk()`, × real time",
            "at 4 ms",
        ),
        "mujoco_steps:over_callbacks",
    ),
    "long": Benchmark(
        "long terrain in MuJoCo", ("at so many segments", *MANY_SEGMENTS[:-1]), "mujoco_steps:over_terrain", 5
    ),
    "many": Benchmark(
        "many walks at once",
        ("walks of gait steps", "steps/s, 1 thread", "2 threads", "ratio", "bare arithmetic"),
        "many:over_walks",
        3,
    ),
    "million": Benchmark(
        "a million gait steps",
        ("walks of gait steps", "steps walked", "ground, s", "walks, s", "CPU, s", "steps/s"),
        "many:millions",
        1,
    ),
    "memory": Benchmark(
        "memory of a walk",
        ("MB of one walk at so many steps: most, kept", "1,000", "10,000", "100,000", "1,000,000"),
        "many:memory",
        1,
    ),
    "environments": Benchmark(
        "steps of environments",
        ("environment", "steps per second", "times the first of its kind"),
        "environments:over_environments",
    ),
    "startup": Benchmark("start of a process", ("process", "CPU time, s", "the first time"), "processes:startup", 7),
    "edited": Benchmark(
        "compiling a changed law",
        ("60 steps in", "a constant changed, s", "the same again, s", "compiling the law, s"),
        "processes:edited",
        7,
    ),
    "frames": Benchmark("frames of a video", ("1280 × 720", "frames/s"), "processes:frames", 7),
}
"""The benchmarks by name, which is also the place of the table on the page."""


@click.command(
    epilog="\b\nNAMES:\n" + "\n".join(f"  {name:14} {benchmark.what}" for name, benchmark in BENCHMARKS.items())
)
@click.argument("names", nargs=-1, metavar="[NAMES]...", type=click.Choice(tuple(BENCHMARKS)))
@click.option("--repeats", type=click.IntRange(1), help="Repetitions of each case, in place of each benchmark's own.")
@click.option(
    "--page",
    default=PAGE,
    show_default=True,
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="Where the tables are written.",
)
def main(names: Sequence[str], repeats: int | None, page: Path) -> None:
    """Run the benchmarks NAMES, or all of them, and write a table of each."""
    for name in names or BENCHMARKS:
        benchmark = BENCHMARKS[name]
        try:
            rows = benchmark.measure(repeats or benchmark.repeats)
        except (ImportError, RenderError) as error:
            click.echo(f"{name}: the table stays as it is: {error}", err=True)
        else:
            show_table(benchmark.what, benchmark.headings, rows, page, name)


if __name__ == "__main__":
    main()
