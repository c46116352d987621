"""Writes the tables and figures of finished robustness studies into docs/tables: robustness.md and kneed_walks.md.

A study is walked by `mjbiped robustness`; the tables that it has written into its folder become CSV files.

    python -m scripts.studies.robustness_page --hybrid out/robustness --margins out/margins
    python -m scripts.studies.robustness_page --knees out/robustness_kneed --knees out/margins_kneed
"""

import shutil
from pathlib import Path

import click

from mjbiped.studies.robustness_report import TABLES
from scripts.pages import without_tables

PAGE, IMAGES = Path("docs/tables/robustness.md"), Path("docs/images")
KNEES_PAGE = Path("docs/tables/kneed_walks.md")
FIGURES = ("survival.png", "limits.png")
"""Of the study in the hybrid engine alone."""

FOLDER = click.Path(exists=True, file_okay=False, path_type=Path)


def tables(folder: Path) -> list[str]:
    """The tables of a study's folder, each with its title and its caption, whole lines."""
    first, *others = (folder / TABLES).read_text(encoding="utf-8").split("\n**")
    return [first.rstrip("\n") + "\n", *(f"**{table.rstrip()}\n" for table in others)]


@click.command(help=__doc__)
@click.option("--hybrid", type=FOLDER, help="Of scripts/studies/robustness.toml.")
@click.option("--mujoco", type=FOLDER, help="Of scripts/studies/robustness_mujoco.toml.")
@click.option("--margins", type=FOLDER, multiple=True, help="Of margins.toml, and of margins_mujoco.toml there.")
@click.option("--slopes", type=FOLDER, help="Of robustness_slopes_mujoco.toml there.")
@click.option("--parts", type=FOLDER, help="Of robustness_parts.toml there.")
@click.option("--basin", type=FOLDER, help="Of basin.toml there.")
@click.option("--knees", type=FOLDER, multiple=True, help="Of the studies with knees there.")
@click.option("--page", default=PAGE, show_default=True, type=click.Path(exists=True, path_type=Path))
@click.option("--knees-page", default=KNEES_PAGE, show_default=True, type=click.Path(exists=True, path_type=Path))
@click.option("--images", default=IMAGES, show_default=True, type=FOLDER)
def main(
    margins: tuple[Path, ...],
    slopes: Path | None,
    knees: tuple[Path, ...],
    page: Path,
    knees_page: Path,
    images: Path,
    **whole: Path | None,
) -> None:
    """Write the tables of the studies that are given."""
    for name, folder in whole.items():
        if folder is not None:
            without_tables("\n".join(tables(folder)), page, f"{name} ")
    for folder in margins:
        without_tables("\n".join(each for each in tables(folder) if each.startswith("**Margins")), page, "margins ")
    for folder in knees:
        # level ground alone, of the study of margins, stands in the other study's first table
        new = (each for each in tables(folder) if not each.startswith("**Level ground,"))
        without_tables("\n".join(new), knees_page, "robustness ")
    if slopes is not None:
        without_tables(next(each for each in tables(slopes) if each.startswith("**treads")), page, "slopes ")
    if (hybrid := whole["hybrid"]) is not None:
        for name in FIGURES:
            shutil.copy(hybrid / name, images / name)


if __name__ == "__main__":
    main()
