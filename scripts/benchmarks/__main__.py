"""Measure how fast mjbiped is, and write the results into docs/tables/performance/.

python -m scripts.benchmarks                      (all of them, some seventeen minutes; or: make bench)
python -m scripts.benchmarks startup frames       (these two)
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Sequence
from pathlib import Path
from pkgutil import resolve_name
from typing import NamedTuple

import click

from mjbiped.errors import RenderError
from scripts.benchmarks.timing import Rows
from scripts.pages import show_table

FOLDER = Path("docs/tables/performance")


class Benchmark(NamedTuple):
    """One table.

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
    name: Benchmark(**benchmark)
    for name, benchmark in tomllib.loads(Path(__file__).with_name("benchmarks.toml").read_text("utf-8")).items()
}
"""The benchmarks by name, which is also the table's."""


@click.command(
    epilog="\b\nNAMES:\n" + "\n".join(f"  {name:14} {benchmark.what}" for name, benchmark in BENCHMARKS.items())
)
@click.argument("names", nargs=-1, metavar="[NAMES]...", type=click.Choice(tuple(BENCHMARKS)))
@click.option("--repeats", type=click.IntRange(1), help="Repetitions of each case, in place of each benchmark's own.")
@click.option("--tables", default=FOLDER, show_default=True, type=Path, help="Folder that gets the tables.")
def main(names: Sequence[str], repeats: int | None, tables: Path) -> None:
    """Run the benchmarks NAMES, or all of them, and write a table of each."""
    for name in names or BENCHMARKS:
        benchmark = BENCHMARKS[name]
        try:
            rows = benchmark.measure(repeats or benchmark.repeats)
        except (ImportError, RenderError) as error:
            click.echo(f"{name}: the table stays as it is: {error}", err=True)
        else:
            show_table(benchmark.what, benchmark.headings, rows, tables, name)


if __name__ == "__main__":
    main()
