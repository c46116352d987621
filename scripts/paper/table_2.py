"""Table II of the paper in the hybrid engine: the reading that fits it best, blind and fitted gains; a minute or two.

python -m scripts.paper.table_2
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import click
from rich.console import Console
from rich.markdown import Markdown

from mjbiped.reproduction.reproduce import filled, misjudged, on_table_2, stored_fits, table_2
from mjbiped.reproduction.rows import walked
from mjbiped.reproduction.section_5 import BLIND, FITTED
from mjbiped.reproduction.table_2 import Results
from mjbiped.reproduction.tables import of_table_2


@click.command(help=__doc__)
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), help="Folder of finished walks; none is kept.")
def main(out: Path | None) -> None:
    """Walk and print."""
    with TemporaryDirectory() as nowhere:
        folder = out or Path(nowhere)
        cells = table_2()
        best = Results(walked(cells, folder, progress=True)).best
        for part, chosen in (("blind", BLIND), ("fitted", FITTED)):
            cells += on_table_2(part, "hybrid", best.places, chosen.values())
        rows = walked([*cells, *misjudged(best)], folder, progress=True)
    sections = {**of_table_2(Results(rows)), **stored_fits()}
    console = Console(width=140)
    console.print(f"{sections['best']}; distance {sections['best_distance']} %")
    for heading in ("Every setting", "Agreement and nearest settings", "Nearest readings"):
        console.print(Markdown(filled(heading, sections)))


if __name__ == "__main__":
    main()
