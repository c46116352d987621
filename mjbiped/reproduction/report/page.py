"""The report: the table of all walks, rendered as a page."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import resources
from string import Template

from mjbiped.reproduction.random_grounds import RandomGround
from mjbiped.reproduction.report import checks, evidence
from mjbiped.reproduction.report import fit as report_fit
from mjbiped.reproduction.report import table_2 as report_table_2
from mjbiped.reproduction.report import table_3 as report_table_3
from mjbiped.reproduction.report.markdown import table
from mjbiped.reproduction.rows import Row
from mjbiped.reproduction.scan import Tried
from mjbiped.reproduction.table_2 import choices

PAGE = "reproduction.md"
TABLE = "reproduction.csv"
TRIED = "reproduction_gains.csv"
GROUNDS = "reproduction_grounds.csv"
PICTURES = "images"


def render(rows: Sequence[Row], tried: Sequence[Tried], grounds: Sequence[RandomGround]) -> str:
    """The page, every number of it from the rows, the settings that were tried and the random grounds.

    Args:
        rows: Of a whole reproduction; walks in MuJoCo may be missing.
        tried: Gains and slope sources of the comparison methods, on the reading that the rows choose.
        grounds: Random ones with their own Tables III.
    """
    template = (resources.files("mjbiped.reproduction") / "template.md").read_text(encoding="utf-8")
    best = choices(rows)[0]
    failed = [[row.ground, row.method, row.engine, row.error] for row in rows if row.outcome == "failed"]
    mujoco_steps = [row.steps for row in rows if (row.part, row.engine) == ("table 2", "mujoco")]
    parts = {
        **report_table_2.sections(rows),
        **report_fit.sections(rows, best, tried),
        **report_table_3.sections(rows),
        **evidence.sections(rows, best, tried, grounds),
        **checks.sections(checks.checks(rows, best)),
        "engine": engine_shown(rows),
        "walks": str(len(rows)),
        "in_mujoco": str(sum(row.engine == "mujoco" for row in rows)),
        "mujoco_steps": str(max(mujoco_steps, default=0)),
        "engine_name": {"mujoco": "MuJoCo", "hybrid": "hybrid engine"}[engine_shown(rows)],
        "failed": table(("ground", "method", "engine", "error"), failed) if failed else "None.",
    }
    return Template(template).substitute(parts)


def engine_shown(rows: Sequence[Row]) -> str:
    """Whose figures the page shows: MuJoCo's where there are any."""
    return "mujoco" if any(row.part == "table 3" and row.engine == "mujoco" for row in rows) else "hybrid"
