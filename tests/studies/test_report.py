"""The committed report: it says what its table says, the table says what is walked, and the prose is true of it."""

import math
from pathlib import Path

import pytest

from mjbiped.studies.cell import Cell
from mjbiped.studies.reproduction import reproduce as plan
from mjbiped.studies.reproduction.cell import COSTS, TRACES
from mjbiped.studies.reproduction.cell import row as row_as_walked
from mjbiped.studies.reproduction.claims import walks_of
from mjbiped.studies.reproduction.reproduce import TABLE
from mjbiped.studies.reproduction.results import Results, Row, read_rows, row_of, side_distances, write_rows
from mjbiped.studies.reproduction.section_5 import STAIRS
from mjbiped.studies.reproduction.tables import TABLES, render
from mjbiped.terrain.profile import GROUND_FRICTION
from scripts.pages import without_tables

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(scope="module")
def rows() -> list[Row]:
    return read_rows((DOCS / TABLE).read_text(encoding="utf-8"))


def identity(row: Row) -> tuple[object, ...]:
    """What a walk is, without what was measured."""
    parts = (row.part, row.ground, row.pattern, row.first, row.engine, row.method, row.slope_source, row.update)
    return *parts, repr(row.delay), repr(row.adaptation_gain), repr(row.start_estimate)


def test_pages_are_made_of_the_table(rows: list[Row], tmp_path: Path) -> None:
    for name, page in render(Results(rows)).items():
        assert (DOCS / name).read_text(encoding="utf-8") == without_tables(page, tmp_path / name)
    stored, written = ((docs / TABLES).with_suffix("").iterdir() for docs in (DOCS, tmp_path))
    assert {file.name: file.read_bytes() for file in stored} == {file.name: file.read_bytes() for file in written}
    assert write_rows(rows) == (DOCS / TABLE).read_text(encoding="utf-8")


@pytest.mark.slow
def test_walks_again_give_the_table(rows: list[Row]) -> None:
    """A share of the hybrid engine's walks, one of each method, ground and part, and some of MuJoCo's."""
    known = {identity(row): row for row in rows}
    cells = [*plan.table_2()[::97], *plan.table_3("hybrid")[::3], *plan.start()[::5], plan.figure_5("hybrid")[1]]
    for cell in (*cells, *plan.table_3("mujoco")[-2:]):
        compare(cell, known)


# six digits are kept; more is other processors' arithmetic, which 60 steps do not magnify;
# distances from a line and ways up and down are sums of differences, and more of the arithmetic is seen in them
TOLERANCES = {
    **dict.fromkeys(("place", "ankle", "hip", "friction", "least_force", *COSTS), (2e-5, 1e-12)),
    **dict.fromkeys(("begun", "ended", "rms"), (0.0, 1e-5)),
    **dict.fromkeys(TRACES, (1e-3, 1e-4)),
}


def compare(cell: Cell, known: dict[tuple[object, ...], Row]) -> None:
    """Walk a cell again and compare it with its row."""
    fresh = row_of(row_as_walked(cell))
    row = known[identity(fresh)]
    assert (fresh.outcome, fresh.steps, fresh.strikes) == (row.outcome, row.steps, row.strikes)
    for name, (relative, absolute) in TOLERANCES.items():
        wanted = pytest.approx(getattr(row, name), rel=relative, abs=absolute, nan_ok=True)
        assert getattr(fresh, name) == wanted, name


def test_table_is_whole(rows: list[Row]) -> None:
    """Every walk of the plan has a row, and none failed with an error."""
    hybrid = [*plan.table_2(), *plan.table_3("hybrid"), *plan.start(), *plan.figure_5("hybrid")]
    best = Results(rows).best
    gravity = plan.gravity(best)
    engines = [sum(row.engine == engine for row in rows) for engine in ("hybrid", "mujoco")]
    compared = [row for row in rows if row.part in ("blind", "fitted", "misjudged") and row.engine == "hybrid"]
    assert len(compared) == 3 * (1 + 1 + 2) * len(best.places)
    assert engines[0] == len(hybrid) + len(gravity) + len(compared)
    assert engines[1] == len(plan.in_mujoco(best, Results(rows).sources[0], False))
    assert not [row for row in rows if row.outcome == "failed"]


def test_prose_is_true_of_the_table(rows: list[Row]) -> None:
    """The sentences of the template that no number carries."""
    best = Results(rows).best
    stairs = {side.stairs[0] for side in side_distances(rows, STAIRS) if math.isfinite(side.distance)}
    assert stairs == {"descending"}, "stairs fit as descending alone"
    assert (best.stairs[0], best.length) == ("descending", 20), "over few steps"
    for ground in ("mixed", "found"):
        for zeta, walk in walks_of(rows, ground, "mujoco").items():
            asked = walks_of(rows, ground, "hybrid")[zeta].friction
            assert walk.outcome in ("finished", "slipped")
            assert walk.finished or asked > GROUND_FRICTION, "walks end where more friction is asked"
        forces = {zeta: walk.least_force for zeta, walk in walks_of(rows, ground, "hybrid").items()}
        assert forces[0.1] < 0.0, "the smallest zeta needs glue"
        assert min(walk.least_force for walk in walks_of(rows, ground, "mujoco").values() if walk.steps) >= 0.0
    assert walks_of(rows, "mixed", "mujoco")[0.1].steps == 0, "the smallest zeta ends in the first step"
    start = {row.delay: row.torque for row in rows if row.part == "start"}
    whole = walks_of(rows, "mixed", "hybrid")
    assert start[0.1] == whole[0.1].torque, "the start alone sets the torque of the smallest zeta"
    assert start[1.0] < whole[1.0].torque
