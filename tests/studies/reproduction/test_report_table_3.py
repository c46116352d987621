"""The report on Table III: where a motion needs a ground that pulls, it says so and gives no friction."""

from __future__ import annotations

from reproduction_rows import made_row

from mjbiped.studies.reproduction.results import Results, Row
from mjbiped.studies.reproduction.section_5 import TABLE_3
from mjbiped.studies.reproduction.tables import pulls, section

HEADINGS = ("Our mixed ground", "The ground that was found")


def walks(forces: dict[tuple[str, float | None], float]) -> list[Row]:
    """The paper's numbers on both grounds, with these least normal forces and 0.5 weights elsewhere."""
    return [
        made_row(
            cost, part="table 3", ground=ground, engine=engine, delay=zeta, ankle=torque,
            friction=84.4, least_force=forces.get((ground, zeta), 0.5) if engine == "hybrid" else 0.01,
        )
        for engine in ("hybrid", "mujoco")
        for ground in ("mixed", "found")
        for zeta, (torque, cost) in TABLE_3.items()
    ]  # fmt: skip


def last_cells(message: str, zeta: str) -> list[str]:
    line = next(line for line in message.splitlines() if line.startswith(f"| {zeta} |"))
    return [cell.strip() for cell in line.split("|")[-4:-1]]


def test_no_friction_is_given_where_the_ground_pulls() -> None:
    rows = walks({("mixed", 0.1): -1.464, ("found", None): -0.01, ("found", 0.2): -0.512})
    mixed, found = (section(Results(rows), heading) for heading in HEADINGS)
    assert last_cells(mixed, "0.1") == ["−1.46", "0.01", "pulls"]
    assert last_cells(mixed, "0.2") == ["0.50", "0.01", "84.4"]
    assert last_cells(found, "none") == ["−0.01", "0.01", "pulls"]
    assert pulls(rows) == (
        "with ζ = 0.1 on our mixed ground, and with no re-planning and ζ = 0.2 on the ground that was found"
    )


def test_where_nothing_pulls_it_says_so() -> None:
    rows = walks({})
    assert pulls(rows) == "with no ζ on our mixed ground, and with no ζ on the ground that was found"
    assert not any("pulls" in section(Results(rows), heading) for heading in HEADINGS)
