"""Table II of the paper in the hybrid engine: the reading that fits it best, blind and fitted gains; a minute or two.

python -m scripts.paper.table_2
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import click
from rich.console import Console
from rich.markdown import Markdown

from mjbiped.studies.reproduction.reproduce import misjudged, on_table_2, table_2, walked
from mjbiped.studies.reproduction.results import Results, number
from mjbiped.studies.reproduction.section_5 import BLIND, FITTED
from mjbiped.studies.reproduction.tables import section


@click.command(help=__doc__)
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), help="Folder of finished walks; none is kept.")
def main(out: Path | None) -> None:
    """Walk and print."""
    with TemporaryDirectory() as nowhere:
        folder, cells = out or Path(nowhere), table_2()
        best = Results(walked(cells, folder, progress=True)).best
        for part, chosen in (("blind", BLIND), ("fitted", FITTED)):
            cells += on_table_2(part, "hybrid", best.places, chosen.values())
        results = Results(walked([*cells, *misjudged(best)], folder, progress=True))
    console = Console(width=140)
    console.print(f"{best.words}; distance {number(100 * best.distance, '.1f')} %")
    for heading in ("Every setting", "Agreement and nearest settings", "Nearest readings"):
        console.print(Markdown(section(results, heading)))


if __name__ == "__main__":
    main()
