"""Table III of the paper, on our mixed ground and on the one that was found for it.

python -m scripts.paper.table_3 --engine mujoco
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import click
from rich.console import Console
from rich.markdown import Markdown

from mjbiped.studies.reproduction.reproduce import start, table_3, walked
from mjbiped.studies.reproduction.results import Results
from mjbiped.studies.reproduction.tables import distances, section


@click.command(help=__doc__)
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), help="Folder of finished walks; none is kept.")
@click.option("--engine", type=click.Choice(("hybrid", "mujoco")), default="hybrid", show_default=True)
def main(out: Path | None, engine: str) -> None:
    """Walk and print."""
    with TemporaryDirectory() as nowhere:
        rows = walked([*table_3(engine), *start()], out or Path(nowhere), progress=True)
    console = Console(width=140)
    for ground, heading in (("mixed", "Our mixed ground"), ("found", "The ground that was found")):
        console.print(f"{ground}: distance {distances(rows, ground)}")
        console.print(Markdown(section(Results(rows), heading)))


if __name__ == "__main__":
    main()
