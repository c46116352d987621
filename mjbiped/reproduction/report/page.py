"""The report: the table of all walks, rendered as a page and an appendix of tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
TABLES = "tables/reproduction.md"
TABLE = "reproduction.csv"
TRIED = "reproduction_gains.csv"
GROUNDS = "reproduction_grounds.csv"
PICTURES = "images"


def render(rows: Sequence[Row], tried: Sequence[Tried], grounds: Sequence[RandomGround]) -> dict[str, str]:
    """Page and tables by file name, every number from the rows, the settings that were tried and the random grounds.

    Args:
        rows: Of a whole reproduction; walks in MuJoCo may be missing.
        tried: Gains and slope sources of the comparison methods, on the reading that the rows choose.
        grounds: Random ones with their own Tables III.
    """
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
    return {PAGE: _filled("template_page.md", parts), TABLES: _filled("template_tables.md", parts)}


def _filled(template: str, parts: Mapping[str, str]) -> str:
    """A template of this package with its places filled."""
    text = (resources.files("mjbiped.reproduction") / template).read_text(encoding="utf-8")
    return Template(text).substitute(parts)


def engine_shown(rows: Sequence[Row]) -> str:
    """Whose figures the page shows: MuJoCo's where there are any."""
    return "mujoco" if any(row.part == "table 3" and row.engine == "mujoco" for row in rows) else "hybrid"
