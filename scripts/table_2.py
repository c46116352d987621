"""Table II of the paper in the hybrid engine, in the reading that fits it best; some seconds.

python scripts/table_2.py
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import click
from rich.console import Console
from rich.markdown import Markdown

from mjbiped.reproduction import plan, report_table_2
from mjbiped.reproduction.running import run_cells
from mjbiped.reproduction.store import Store


@click.command(help=__doc__)
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), help="Folder of finished walks; none is kept.")
def main(out: Path | None) -> None:
    """Walk and print."""
    with TemporaryDirectory() as folder:
        entries = plan.table_2()
        results = run_cells([entry.cell for entry in entries], Store(out or Path(folder)), progress=True)
    told = report_table_2.sections([entry.row(results[entry.cell.key]) for entry in entries])
    console = Console(width=120)
    console.print(f"{told['best']}; slope of the other methods: {told['source']}; distance {told['best_distance']} %")
    for name in ("table_2", "agreement", "nearest"):
        console.print(Markdown(told[name]))


if __name__ == "__main__":
    main()
