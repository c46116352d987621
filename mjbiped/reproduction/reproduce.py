"""The whole reproduction of section V: walks, tables, page and figures."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from string import Template

from mjbiped.plotting.style import make_small
from mjbiped.plotting.walk import plot_walk
from mjbiped.records.record import Walk
from mjbiped.reproduction import plan
from mjbiped.reproduction.cell import record_path, walked
from mjbiped.reproduction.grounds import FILES, PRINTED, READINGS
from mjbiped.reproduction.methods import BLIND, FITTED, METHODS, SETTLED, Variant, settled
from mjbiped.reproduction.plan import on_table_2
from mjbiped.reproduction.report import checks, fit, table_2, table_3
from mjbiped.reproduction.report.figures import plot_figure_5, plot_figure_6, plot_table_3
from mjbiped.reproduction.rows import Row, select, write_rows
from mjbiped.reproduction.table_2 import Choice, choices, sources_ranked
from mjbiped.sweeps.cell import FAILED, Cell
from mjbiped.sweeps.store import make_folder
from mjbiped.utils.files import saved
from mjbiped.utils.markdown import markdown_table

PAGE = "reproduction.md"
TABLES = "tables/reproduction.md"
TEMPLATES = {PAGE: "template_page.md", TABLES: "template_tables.md"}
TABLE = "reproduction.csv"
GAINS_TABLE, GROUNDS_TABLE = SEARCHED = ("reproduction_gains.csv", "reproduction_grounds.csv")
"""Stored results of the searches that the page links to; `scripts/paper/fits.py` has made them."""

FITS = "fits.json"
"""Texts of the page about these searches."""

PICTURES = "images"
PRINTS = "figures"
MUJOCO_STEPS = 60
QUICK_STEPS = 20


def reproduce(
    folder: Path,
    *,
    quick: bool = False,
    workers: int | None = None,
    report: Path | None = None,
    fresh: bool = False,
    progress: bool = False,
) -> tuple[list[Row], list[Path]]:
    """Walk everything, and write the table, the pages and the figures.

    Args:
        folder: Folder of the finished walks, which are not walked again.
        quick: All walks in the hybrid engine, but only a few short ones in MuJoCo.
        workers: Processes; one for each core unless given.
        report: Folder for the page, its table and its figures; the same folder unless given.
        fresh: Delete finished walks, and begin again.
        progress: Show a progress bar (never where the output is not a terminal).

    Returns:
        The rows of the table, and the files that were written.

    Raises:
        InputError: A folder cannot be made, or another process walks in it.
        RecordError: A file cannot be written, or the finished walks are damaged.
        RenderError: A figure cannot be written.
        MjbipedError: A process died.
    """
    report = report or folder
    for needed in (report / PICTURES, (report / TABLES).parent, folder / PRINTS):
        make_folder(needed)
    walks, rows_of = folder / "walks", partial(walked, workers=workers, progress=progress)
    cells = [*plan.table_2(), *plan.table_3("hybrid"), *plan.start(), *plan.figure_5("hybrid")]
    rows = rows_of(cells, walks, fresh=fresh)
    best = choices(rows)[0]
    more = [
        *plan.gravity(best),
        *on_table_2("blind", "hybrid", best.places, BLIND.values()),
        *on_table_2("fitted", "hybrid", best.places, FITTED.values()),
        *plan.misjudged(best),
        *in_mujoco(best, sources_ranked(rows, best)[0], quick),
    ]
    rows += rows_of(more, walks)
    texts = {TABLE: write_rows(rows), **{name: _stored(f"fits/{name}") for name in SEARCHED}, **render(rows)}
    for name, text in texts.items():
        with saved(report / name) as unfinished:
            unfinished.write_text(text, encoding="utf-8")
    recorded = [
        (row, Walk.load(record_path(walks, cell)))
        for row, cell in zip(rows, [*cells, *more], strict=True)
        if cell.values.get("record")
    ]
    return rows, [*(report / name for name in texts), *draw(recorded, rows, report / PICTURES, folder / PRINTS)]


def in_mujoco(best: Choice, source: str, quick: bool) -> list[Cell]:
    """List the walks that MuJoCo repeats.

    Args:
        best: The reading of Table II's grounds that fits.
        source: Slope source for the energy-based methods with gains that settle.
        quick: Whether only a few short ones.
    """
    chosen = [Variant("adaptive", delay) for delay in dict.fromkeys((best.delay, *plan.DRAWN_DELAYS[1:]))]
    if quick:
        return on_table_2("table 2", "mujoco", best.places, chosen[:1], QUICK_STEPS)
    chosen += [
        settled(method, named)
        for method in METHODS[1:]
        for named in dict.fromkeys((source, SETTLED[method].slope_source))
    ]
    steps, both = max(MUJOCO_STEPS, best.length), {*best.places, *PRINTED}
    return [
        *on_table_2("table 2", "mujoco", [place for place in READINGS if place in both], chosen, steps),
        *on_table_2("blind", "mujoco", best.places, BLIND.values(), steps),
        *on_table_2("fitted", "mujoco", best.places, FITTED.values(), steps),
        *plan.table_3("mujoco"),
        *plan.figure_5("mujoco"),
    ]


def draw(recorded: Sequence[tuple[Row, Walk]], rows: Sequence[Row], pages: Path, prints: Path) -> list[Path]:
    """Draw Figs. 4 to 6 of each engine that has the walks, and Table III.

    Args:
        recorded: Walks whose records are kept, with their rows.
        rows: Rows of all walks.
        pages: Folder for the figures that the page shows, small PNG files.
        prints: Folder for all figures as PDF files.

    Returns:
        The files.
    """
    drawings: dict[str, Callable[[Path], object]] = {"table_3": partial(plot_table_3, rows)}
    for engine in dict.fromkeys(row.engine for row, _ in recorded):
        mine = [(row, walk) for row, walk in recorded if row.engine == engine]
        by_delay = {row.delay: walk for row, walk in mine if (row.part, row.ground) == ("table 3", "mixed")}
        curves: dict[float, dict[tuple[float, bool], Walk]] = {gain: {} for gain in plan.ADAPTATION_GAINS}
        for row, walk in mine:
            if row.part == "figure 5":
                curves[row.adaptation_gain][row.start_estimate, row.update == "yes"] = walk
        drawings |= {
            f"fig_6_mixed_{engine}": partial(plot_figure_6, {delay: by_delay[delay] for delay in plan.DRAWN_DELAYS}),
            f"fig_5_{engine}": partial(plot_figure_5, curves),
            f"fig_4_mixed_{engine}": partial(plot_walk, curves[plan.PAPER_GAIN][plan.START_ESTIMATES[0], True]),
        }
    written = []
    for name, make in drawings.items():
        written.append(prints / f"reproduction_{name}.pdf")
        make(written[-1])
        if name.endswith((engine_shown(rows), "table_3")):
            written.append(pages / f"reproduction_{name}.png")
            make(written[-1])
            make_small(written[-1])
    return written


def _stored(file: str) -> str:
    """Read a text that is part of this package."""
    return FILES.joinpath(file).read_text(encoding="utf-8")


def stored_fits() -> dict[str, str]:
    """Read the texts about the fits to the paper's tables, by their places in the templates."""
    found: dict[str, str] = json.loads(_stored(f"fits/{FITS}"))
    return found


def render(rows: Sequence[Row]) -> dict[str, str]:
    """Write the page and its tables, by file name, from the rows of a reproduction and the stored results of the fits.

    Args:
        rows: Rows of a whole reproduction; walks in MuJoCo may be missing.
    """
    failed = [[row.ground, row.method, row.engine, row.error] for row in select(rows, outcome=FAILED)]
    in_mujoco, engine, found = select(rows, engine="mujoco"), engine_shown(rows), choices(rows)
    parts = {
        **table_2.sections(rows, found),
        **fit.sections(rows, found[0]),
        **table_3.sections(rows),
        **stored_fits(),
        **checks.sections(checks.checks(rows, found[0])),
        "engine": engine,
        "engine_name": {"mujoco": "MuJoCo", "hybrid": "hybrid engine"}[engine],
        "walks": str(len(rows)),
        "in_mujoco": str(len(in_mujoco)),
        "mujoco_steps": str(max((row.steps for row in select(in_mujoco, part="table 2")), default=0)),
        "failed": markdown_table(("ground", "method", "engine", "error"), failed, 1) if failed else "None.",
    }
    return {name: Template(_stored(file)).substitute(parts) for name, file in TEMPLATES.items()}


def filled(heading: str, parts: Mapping[str, str]) -> str:
    """Write the section of the page of tables that has a heading."""
    whole = _stored(TEMPLATES[TABLES]).partition(f"\n### {heading}\n")[2].partition("\n#")[0]
    return Template(whole).safe_substitute(parts)


def engine_shown(rows: Sequence[Row]) -> str:
    """Name of the engine whose figures the page shows: MuJoCo where it has any."""
    return "mujoco" if select(rows, part="table 3", engine="mujoco") else "hybrid"
