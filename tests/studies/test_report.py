"""The committed report: it says what its table says, the table says what is walked, and the prose is true of it."""

import math
from pathlib import Path

import pytest

from mjbiped.studies.cell import Cell
from mjbiped.studies.reproduction import reproduce as plan
from mjbiped.studies.reproduction.cell import COSTS, RESOLVED_SLOPE, TRACES
from mjbiped.studies.reproduction.cell import row as row_as_walked
from mjbiped.studies.reproduction.claims import walks_of
from mjbiped.studies.reproduction.reproduce import TABLE
from mjbiped.studies.reproduction.results import Results, Row, read_rows, row_of, side_distances, write_rows
from mjbiped.studies.reproduction.section_5 import PRINTED, SLOPES, STAIRS, TABLE_3
from mjbiped.studies.reproduction.tables import TABLES, distance, render
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
    there, few = (plan.in_mujoco(best, Results(rows).sources[0], quick) for quick in (False, True))
    assert engines[1] == len(there)
    steps = [{cell.values["limit.steps"] for cell in some if cell.values["part"] == "table 2"} for some in (there, few)]
    assert (steps, len(few)) == ([{60}, {20}], len(best.places))
    assert not [row for row in rows if row.outcome == "failed"]


def test_prose_is_true_of_the_table(rows: list[Row]) -> None:
    """The sentences of the template that no number carries."""
    best = Results(rows).best
    stairs = {side.stairs[0] for side in side_distances(rows, STAIRS) if math.isfinite(side.distance)}
    assert stairs == {"descending"}, "stairs fit as descending alone"
    slopes: dict[str, float] = {}
    for side in side_distances(rows, SLOPES):
        slopes[side.slopes[0]] = min(side.distance, slopes.get(side.slopes[0], math.inf))
    assert min(slopes["accumulating downhill"], slopes["accumulating uphill"]) > 0.3, "added up they are far off"
    ranked = sorted(slopes, key=lambda pattern: slopes[pattern])
    assert all(pattern.startswith("down and up in turn") for pattern in ranked[:2]), "beginning downhill"
    assert best.slopes[0] in ranked[:2]
    assert (best.stairs[0], best.length) == ("descending", 20), "over few steps"
    table_2 = [row for row in rows if row.part == "table 2"]
    climbing = {row.finished for row in table_2 if row.place_read[:2] == PRINTED[1][:2] == ("stair 2", "ascending")}
    assert climbing == {False}, "nothing walks up stair 2"
    assert Results(rows).readings[9].distance / best.distance < 1.5, "the next ones are as good"
    assert sum(row.part == "gravity" for row in rows) == 5
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
    costs = {
        (row.ground, row.delay): best.cost(row)
        for row in table_2
        if (row.engine, row.method) == ("hybrid", "adaptive") and row.place_read in best.places
    }
    assert costs["stair 1", 0.8] < costs["stair 1", None], "on stair 1 re-planning saves"
    assert costs["stair 2", 0.8] > costs["stair 2", None], "on stair 2 it costs"


def test_prose_on_figure_5_is_true_of_the_table(rows: list[Row]) -> None:
    mine = [row for row in rows if row.part == "figure 5"]
    walks = {(row.engine, row.adaptation_gain, row.start_estimate, row.update): row for row in mine}
    assert len(walks) == 2 * 4 * 2 * 2
    small = math.degrees(RESOLVED_SLOPE)
    for (engine, gain, start, update), walk in walks.items():
        other = walks[engine, gain, start, "no" if update == "yes" else "yes"]
        assert walk.trace_settled == pytest.approx(other.trace_settled, rel=1e-5), "alike before the first change"
        if update == "yes":
            assert walk.jump < 0.02, "(27) leaves an error as it is"
            assert walk.trace_off_time < other.trace_off_time
            if gain in (0.3, 3.0):
                assert walk.trace_later < small, "along at once"
        else:
            assert walk.begun > 1.0
            assert (walk.ended > small) == (gain == 0.03), "it does not get there before the next change"
            fast = walks[engine, 3.0, start, update].trace_off_time
            assert (walk.trace_off_time > fast) == (gain != 3.0)


def test_found_ground_is_nearer_to_table_3_than_ours(rows: list[Row]) -> None:
    for engine in ("hybrid", "mujoco"):
        found, mixed = (distance(walks_of(rows, ground, engine)) for ground in ("found", "mixed"))
        assert found < 0.1 < mixed
    assert set(walks_of(rows, "found", "mujoco")) == set(TABLE_3)
