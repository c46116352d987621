"""The whole reproduction of section V: its walks, tables, pages and figures."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

from mjbiped.records.record import Walk
from mjbiped.rules.termination import Outcome
from mjbiped.studies.cell import LIMIT, Cell
from mjbiped.studies.reproduction import cell as cells
from mjbiped.studies.reproduction import section_5 as paper
from mjbiped.studies.reproduction.cell import KEY_DIGITS, LENGTHS, cell, key, record_path
from mjbiped.studies.reproduction.figures import draw
from mjbiped.studies.reproduction.results import COLUMNS, Choice, Results, Row, row_of, write_rows
from mjbiped.studies.reproduction.tables import TABLES, render, stored
from mjbiped.studies.run import walk_cells
from mjbiped.studies.store import make_folder, opened
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.files import saved

TABLE = "reproduction.csv"
GAINS_TABLE, GROUNDS_TABLE = SEARCHED = ("reproduction_gains.csv", "reproduction_grounds.csv")
"""Stored results of the searches that the page links to; `scripts/paper/fits.py` has made them."""

PICTURES = "images"
PRINTS = "figures"
MUJOCO_STEPS = 60
QUICK_STEPS = 20
MIXED_STEPS = 60
OTHER_GRAVITY = 9.8  # m/s²
_ENDS = {outcome.words for outcome in Outcome}


def reproduce(
    folder: Path,
    *,
    quick: bool = False,
    workers: int | None = None,
    report: Path | None = None,
    fresh: bool = False,
    progress: bool = False,
) -> tuple[Results, list[Path]]:
    """Walk everything, and write the table, the pages and the figures.

    Args:
        folder: Folder of the finished walks, which are not walked again.
        quick: All walks in the hybrid engine, but only a few short ones in MuJoCo.
        workers: Processes; one for each core unless given.
        report: Folder for the page, its table and its figures; the same folder unless given.
        fresh: Delete finished walks, and begin again.
        progress: Show a progress bar (never where the output is not a terminal).

    Returns:
        The results, and the files that were written.

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
    cells = [*table_2(), *table_3("hybrid"), *start(), *figure_5("hybrid")]
    first = Results(rows_of(cells, walks, fresh=fresh))
    best = first.best
    cells += [
        *gravity(best),
        *on_table_2("blind", "hybrid", best.places, paper.BLIND.values()),
        *on_table_2("fitted", "hybrid", best.places, paper.FITTED.values()),
        *misjudged(best),
        *in_mujoco(best, first.sources[0], quick),
    ]
    rows = rows_of(cells, walks)
    results = Results(rows)
    texts = {TABLE: write_rows(rows), **{name: stored(f"fits/{name}") for name in SEARCHED}, **render(results)}
    for name, text in texts.items():
        with saved(report / name) as unfinished:
            unfinished.write_text(text, encoding="utf-8")
    recorded = [
        (row, Walk.load(record_path(walks, each)))
        for row, each in zip(rows, cells, strict=True)
        if each.values.get("record")
    ]
    return results, [*(report / name for name in texts), *draw(recorded, rows, report / PICTURES, folder / PRINTS)]


def walked(
    planned: Sequence[Cell], folder: Path, *, fresh: bool = False, workers: int | None = None, progress: bool = False
) -> list[Row]:
    """Return the rows of cells; those that are not kept in a folder yet are walked, and kept there as they end.

    The rows do not depend on the number of workers. A cell that fails has a row with the error's text, and is walked
    again the next time.

    Args:
        planned: Any number of cells; equal ones are walked once.
        folder: Folder of a table, and of a file for each record that is kept; it is made if missing.
        fresh: Delete the walks that are kept.
        workers: Number of processes that walk; one for each core unless given.
        progress: Show a progress bar (never where the output is not a terminal).

    Raises:
        InputError: The folder cannot be made, or another process has it.
        RecordError: The table is damaged, or a file cannot be written.
        MjbipedError: A process died, of lack of memory perhaps; what had ended is kept.
        KeyboardInterrupt: Ctrl-C; what had ended is kept.
    """
    keys = [key(cell) for cell in planned]
    wanted = dict(zip(keys, planned, strict=True))
    with opened(folder, "walks", ("key", *COLUMNS), {}, fresh=fresh) as store:
        for file in folder.glob(f"{'[0-9a-f]' * KEY_DIGITS}.npz") if fresh else ():
            file.unlink()
        kept = {row["key"] for row in store.rows() if row["outcome"] in _ENDS}  # others failed, or are damaged
        todo = [
            cell
            for known, cell in wanted.items()
            if known not in kept or (cell.values.get("record") and not record_path(folder, cell).exists())
        ]
        # MuJoCo's take the longest, and longer the more steps they have
        todo.sort(key=lambda cell: (cell.values["engine"] != "mujoco", -int(cell.values.get(f"{LIMIT}.steps", 0))))
        ended = len(wanted) - len(todo)
        walk_cells(partial(cells.row, folder=folder), todo, store.save, ended=ended, workers=workers, progress=progress)
        found = {row["key"]: row_of(row) for row in store.rows()}
    return [found[each] for each in keys]


def on_table_2(
    part: str,
    engine: str,
    places: Iterable[paper.Place],
    chosen: Collection[paper.Variant],
    steps: int = max(LENGTHS),
    **robot: Any,
) -> list[Cell]:
    """List the walks of some paper.variants of the methods on some of Table II's grounds as they are read."""
    role = {"part": part, "engine": engine, "steps": steps, **robot}
    return [
        cell(ground, each.law(ground), method=each.method, **place._asdict(), **role)
        for place, ground in ((place, paper.terrain_of(place)) for place in places)
        for each in chosen
    ]


def table_2() -> list[Cell]:
    """List the walks of every variant of every method on every reading of every ground, in the hybrid engine."""
    return on_table_2("table 2", "hybrid", paper.READINGS, [*paper.variants()])


def misjudged(best: Choice) -> list[Cell]:
    """List the fitted settings' walks with a start slope wrong by `START_ERROR` either way, in the hybrid engine."""
    errors = (paper.START_ERROR, -paper.START_ERROR)
    wrong = [replace(each, start_error=error) for each in paper.FITTED.values() for error in errors]
    return on_table_2("misjudged", "hybrid", best.places, wrong)


def gravity(best: Choice) -> list[Cell]:
    """List the paper.adaptive controller's walks on the best reading with g = 9.8 m/s²."""
    robot: dict[str, Any] = {"robot.gravity": OTHER_GRAVITY}
    return on_table_2("gravity", "hybrid", best.places, [paper.Variant("adaptive", best.delay)], **robot)


def in_mujoco(best: Choice, source: str, quick: bool) -> list[Cell]:
    """List the walks that MuJoCo repeats.

    Args:
        best: The reading of Table II's grounds that fits.
        source: Slope source for the energy-based methods with gains that settle.
        quick: Whether only a few short ones.
    """
    chosen = [paper.Variant("adaptive", delay) for delay in dict.fromkeys((best.delay, *paper.DRAWN_DELAYS[1:]))]
    if quick:
        return on_table_2("table 2", "mujoco", best.places, chosen[:1], QUICK_STEPS)
    for method, variant in paper.SETTLED.items():
        chosen += [paper.settled(method, named) for named in dict.fromkeys((source, variant.slope_source))]
    steps, both = max(MUJOCO_STEPS, best.length), {*best.places, *paper.PRINTED}
    return [
        *on_table_2("table 2", "mujoco", [place for place in paper.READINGS if place in both], chosen, steps),
        *on_table_2("blind", "mujoco", best.places, paper.BLIND.values(), steps),
        *on_table_2("fitted", "mujoco", best.places, paper.FITTED.values(), steps),
        *table_3("mujoco"),
        *figure_5("mujoco"),
    ]


def table_3(engine: str) -> list[Cell]:
    """List the walks of Table III on our mixed ground and on the one found; those of Fig. 6 keep records."""
    grounds = {
        Terrain.mixed(): {"ground": "mixed", "steps": MIXED_STEPS},
        Terrain.from_segments(paper.FOUND): {"ground": "found", "distance": paper.end_of(paper.FOUND)},
    }
    role = {"engine": engine, "initial": "rest", "part": "table 3"}
    return [
        cell(terrain, paper.adaptive(delay), record=delay in paper.DRAWN_DELAYS, **role, **mine)
        for terrain, mine in grounds.items()
        for delay in paper.TABLE_3
    ]


def start() -> list[Cell]:
    """List the first step alone of Table III's walks: from rest on level ground, in the hybrid engine."""
    role = {"engine": "hybrid", "initial": "rest", "part": "start", "ground": "level"}
    return [cell(Terrain.level(), paper.adaptive(delay), steps=1, **role) for delay in paper.TABLE_3]


def figure_5(engine: str) -> list[Cell]:
    """List the walks of Fig. 5: with and without the estimate update, from estimates that are wrong either way.

    From a right one the paper.adaptive law (17) would have nothing to do, for the update (27) keeps it right.
    """
    role = {"engine": engine, "initial": "rest", "part": "figure 5", "ground": "mixed", "record": True}
    names = ("replanning_delay", "adaptation_gain", "initial_slope_estimate_deg", "estimate_update")
    settings = product(paper.DRAWN_DELAYS[1:2], paper.ADAPTATION_GAINS, paper.START_ESTIMATES, (True, False))
    laws = [paper.adaptive(**dict(zip(names, each, strict=True))) for each in settings]
    return [cell(Terrain.mixed(), law, steps=MIXED_STEPS, **role) for law in laws]
