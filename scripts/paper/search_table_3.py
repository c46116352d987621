"""Look for the mixed ground on which Table III comes out; some six minutes.

python -m scripts.paper.search_table_3

The result is the data file mjbiped/reproduction/table_3_terrain.toml.
"""

import click

from mjbiped.reproduction.search import search


@click.command(help=__doc__)
@click.option("--seed", default=0, show_default=True, type=click.IntRange(min=0), help="Of the generator.")
@click.option("--generations", default=160, show_default=True, type=click.IntRange(min=1), help="At most so many.")
def main(seed: int, generations: int) -> None:
    """Search and print the ground as its file has it."""
    found = search(seed, generations, progress=True)
    click.echo(f"# distance {100 * found.distance:.2f} %, {found.evaluations} grounds walked")
    click.echo("segments = [")
    for segment in found.segments:
        click.echo(f"    {list(segment)},")
    click.echo("]")


if __name__ == "__main__":
    main()
