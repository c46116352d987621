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
from mjbiped.reproduction.methods import BLIND, FITTED
from mjbiped.reproduction.report import fit as report_fit
from mjbiped.reproduction.report import table_2 as report_table_2
from mjbiped.reproduction.reproduce import stored_fits, walked
from mjbiped.reproduction.table_2 import choices


@click.command(help=__doc__)
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), help="Folder of finished walks; none is kept.")
def main(out: Path | None) -> None:
    """Walk and print."""
    with TemporaryDirectory() as folder, opened_walks(out or Path(folder), progress=True) as kept:
        rows = walked(plan.table_2(), kept)
        best = choices(rows)[0]
        for part, chosen in (("blind", BLIND), ("fitted", FITTED)):
            rows += walked(plan.compared(part, best, chosen.values(), "hybrid", max(LENGTHS)), kept)
        rows += walked(plan.misjudged(best, FITTED.values()), kept)
    sections = {**report_table_2.sections(rows), **report_fit.sections(rows, best), **stored_fits()}
    console = Console(width=140)
    console.print(f"{sections['best']}; distance {sections['best_distance']} %")
    for name in ("table_2_whole", "agreement", "fits", "nearest"):
        console.print(Markdown(sections[name]))


if __name__ == "__main__":
    main()
