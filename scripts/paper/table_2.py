"""Table II of the paper in the hybrid engine: the reading that fits it best, blind and fitted gains; a minute or two.

python -m scripts.paper.table_2
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import click
from rich.console import Console
from rich.markdown import Markdown

from mjbiped.reproduction import plan
from mjbiped.reproduction.cell import LENGTHS, opened_walks
from mjbiped.reproduction.methods import BLIND
from mjbiped.reproduction.report import fit as report_fit
from mjbiped.reproduction.report import table_2 as report_table_2
from mjbiped.reproduction.reproduce import walked
from mjbiped.reproduction.table_2 import choices, fitted, scan


@click.command(help=__doc__)
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), help="Folder of finished walks; none is kept.")
def main(out: Path | None) -> None:
    """Walk and print."""
    with TemporaryDirectory() as folder, opened_walks(out or Path(folder), progress=True) as kept:
        rows = walked(plan.table_2(), kept)
        best = choices(rows)[0]
        tried = scan(best, kept)
        nearest = [each.variant for each in fitted(tried).values()]
        for part, chosen in (("blind", [*BLIND.values()]), ("fitted", nearest)):
            rows += walked(plan.compared(part, best, chosen, "hybrid", max(LENGTHS)), kept)
    sections = {**report_table_2.sections(rows), **report_fit.sections(rows, best, tried)}
    console = Console(width=140)
    console.print(f"{sections['best']}; distance {sections['best_distance']} %")
    for name in ("table_2", "agreement", "fits", "nearest"):
        console.print(Markdown(sections[name]))


if __name__ == "__main__":
    main()
