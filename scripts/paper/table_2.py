"""Table II of the paper in the hybrid engine: the reading that fits it best, blind and fitted gains; a minute or two.

python -m scripts.paper.table_2
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import click
from rich.console import Console
from rich.markdown import Markdown

from mjbiped.reproduction import plan
from mjbiped.reproduction.cell import walked
from mjbiped.reproduction.methods import BLIND, FITTED
from mjbiped.reproduction.report import fit, table_2
from mjbiped.reproduction.reproduce import filled, stored_fits
from mjbiped.reproduction.table_2 import choices


@click.command(help=__doc__)
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), help="Folder of finished walks; none is kept.")
def main(out: Path | None) -> None:
    """Walk and print."""
    with TemporaryDirectory() as nowhere:
        folder = out or Path(nowhere)
        rows = walked(plan.table_2(), folder, progress=True)
        found = choices(rows)
        for part, chosen in (("blind", BLIND), ("fitted", FITTED)):
            rows += walked(plan.on_table_2(part, "hybrid", found[0].places, chosen.values()), folder, progress=True)
        rows += walked(plan.misjudged(found[0]), folder, progress=True)
    sections = {**table_2.sections(rows, found), **fit.sections(rows, found[0]), **stored_fits()}
    console = Console(width=140)
    console.print(f"{sections['best']}; distance {sections['best_distance']} %")
    for heading in ("Every setting", "Agreement and nearest settings", "Nearest readings"):
        console.print(Markdown(filled(heading, sections)))


if __name__ == "__main__":
    main()
