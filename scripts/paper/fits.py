"""Fit the comparison methods' gains and slope sources to Table II, and say what each fit of the reproduction is worth.

python -m scripts.paper.fits

The settings found stand in `section_5.toml` of `mjbiped/studies/reproduction/`. All results are stored in `fits/`,
from where `mjbiped reproduce` takes the texts of its page.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import click
import numpy as np

from mjbiped.records.measures import WORK_KINDS
from mjbiped.studies.reproduction.cell import LENGTHS
from mjbiped.studies.reproduction.claims import walks_of
from mjbiped.studies.reproduction.reproduce import GAINS_TABLE, GROUNDS_TABLE, TABLE
from mjbiped.studies.reproduction.results import NONE, Results, number, read_rows, share
from mjbiped.studies.reproduction.section_5 import (
    BLIND,
    DELAYS,
    FIRST_CHANGES,
    FIRST_RISERS,
    GROUNDS,
    SLOPE_PATTERNS,
    SLOPE_SOURCES,
    STAIR_PATTERNS,
    TABLE_2,
    Variant,
    agreement,
    gains_told,
)
from mjbiped.studies.reproduction.tables import FITS, distance, printed
from mjbiped.utils.files import markdown_table
from scripts.paper import placebo
from scripts.paper.gain_scan import Tried, fitted, ranked, scan, write_tried
from scripts.paper.placebo import Placebo, RandomGround

SMALL_SHARE = 0.05
"""Of random rows that are met as near as the paper's: below, the fit is evidence."""

_AS_NEAR = 0.005  # of the distance, for settings that are as good as the nearest


def sections(results: Results, tried: Sequence[Tried], grounds: Sequence[RandomGround]) -> dict[str, str]:
    """Fill the places of the page's templates about the fits, by name.

    Args:
        results: The reproduction.
        tried: Gains and slope sources of the comparison methods, on the reading that the rows choose.
        grounds: Random grounds with their own Tables III.
    """
    whole = agreement(
        (method, ground, value) for method, each in fitted(tried).items() for ground, value in each.cost.items()
    )
    levels = (each.cost["level"] for each in tried if each.variant.method == "PBC" and each.cost["level"] > 0.0)
    found = distance(walks_of(results.rows, "found", "hybrid"))
    fits, others = {method: placebo.of_method(tried, method) for method in fitted(tried)}, placebo.to_another(grounds)
    return {
        "fits": _fits(tried),
        "fit_agreement": whole.in_kind,
        "fit_met": f"{whole.met} of {whole.numbers}",
        "fit_distance": number(100 * whole.distance, ".1f"),
        "survivors": _survivors(tried, "stair 2"),
        "as_near": _as_near(tried),
        "pbc_falls": _falls(tried, "PBC", "slope 2"),
        "pbc_level": number(min(levels, key=lambda value: abs(value - TABLE_2["PBC"]["level"])), ".5f"),
        "fits_worth": _worth(results, fits, grounds, found),
        "fit_shares": ", ".join(f"{share(each.share)} ({method})" for method, each in fits.items()),
        "evident": _evident(fits),
        "grounds_walked": str(sum(bool(each.torques) for each in grounds)),
        "to_another": share(float(np.median(others)), ".1f"),
        "to_another_share": share(float(np.mean(others <= found))),
    }


def _fits(tried: Sequence[Tried]) -> str:
    """Tabulate the nearest setting of each method with each slope source, and of KETC with one joint and with both."""
    lines = []
    for method, chosen in fitted(tried).items():
        kinds: dict[tuple[str, float | None], Tried] = {}
        for each in ranked(each for each in tried if each.variant.method == method):
            kinds.setdefault((each.variant.slope_source, dict(each.variant.gains).get("hip_weight")), each)
        for each in kinds.values():
            gains = _gains(each.variant) + (" *" if each is chosen else "")
            costs = (f"X {each.ended[g]}" if g in each.ended else number(each.cost[g]) for g in GROUNDS)
            found = each.agreement
            distance = number(100 * found.distance, ".1f")
            lines.append([method, gains, each.variant.slope_source, found.in_kind, distance, *costs])
        lines.append([method, "paper", NONE, NONE, NONE, *(printed(method, ground) for ground in GROUNDS)])
    return markdown_table(("method", "gains", "slope", "X and numbers", "distance %", *GROUNDS), lines, 1)


def _gains(variant: Variant) -> str:
    """Write a setting's gains for the page."""
    return gains_told(dict(variant.gains)).replace("-", "−")


def _as_near(tried: Sequence[Tried]) -> str:
    """Count the settings of each method that are as good as its nearest, in words."""
    parts = []
    for method, nearest in fitted(tried).items():
        mine = [each.agreement for each in tried if each.variant.method == method]
        best = nearest.agreement
        near = sum(each.agreeing == best.agreeing and each.distance <= best.distance + _AS_NEAR for each in mine)
        parts.append(f"{near} of {len(mine)} for {method}")
    return ", ".join(parts)


def _falls(tried: Sequence[Tried], method: str, ground: str) -> str:
    """Count the settings of each slope source with which a method does not come to the end of a ground."""
    parts = []
    for source in SLOPE_SOURCES:
        mine = [each for each in tried if (each.variant.method, each.variant.slope_source) == (method, source)]
        parts.append(f'{sum(ground in each.ended for each in mine)} ("{source}")')
    return f"{', '.join(parts[:-1])} or {parts[-1]}"


def _survivors(tried: Sequence[Tried], ground: str) -> str:
    """List the settings that come to the end of a ground, in words."""
    through = [each.variant for each in tried if ground not in each.ended]
    named = "; ".join(f"{each.method} {_gains(each)}, {each.slope_source}" for each in through)
    return f"{len(through)} of {len(tried)}" + (f" ({named})" if through else "")


def _evident(fits: Mapping[str, Placebo]) -> str:
    """Say in words which fits of the comparison methods are evidence."""
    named = [method for method, each in fits.items() if each.share < SMALL_SHARE]
    return f"the fit is evidence for {' and '.join(named)}" if named else "no fit of a comparison method is evidence"


def _worth(results: Results, fits: Mapping[str, Placebo], grounds: Sequence[RandomGround], searched: float) -> str:
    """Tabulate every fit beside fits to random rows."""
    read = (DELAYS, WORK_KINDS, LENGTHS, FIRST_RISERS, STAIR_PATTERNS, FIRST_CHANGES, SLOPE_PATTERNS)
    lines = [_line("reading of the grounds, by the adaptive controller", len(read), "", placebo.of_readings(results))]
    for method, found in fits.items():
        free = 1 + len(BLIND[method].gains)
        crosses = f" and {sum(map(math.isnan, TABLE_2[method].values()))} X"
        lines.append(_line(f"gains and slope source of {method}", free, crosses, found))
    free, found = len(placebo.bounds()), placebo.of_table_3(grounds)
    distance = number(100 * searched, ".1f")
    lines.append(["ground of Table III, searched", str(free), str(found.numbers), *[NONE] * 2, distance, *[NONE] * 3])
    lines.append(_line("the same, random grounds", free, "", found, "of the law, not of the ground"))
    met, as_near = "random rows: half are met within %", "random rows met as near as the paper's"
    headings = (
        "fit",
        "free choices",
        "numbers met",
        "of them varied",
        "settings",
        "distance %",
        met,
        as_near,
        "evidence",
    )
    return markdown_table(headings, lines, 1)


def _line(name: str, free: int, crosses: str, found: Placebo, kind: str = "some") -> list[str]:
    distances = (number(100 * value, ".1f") for value in (found.distance, found.random))
    evidence = kind if found.share < SMALL_SHARE else "none"
    counts = (str(free), f"{found.numbers}{crosses}", str(found.varied), str(found.tried))
    return [name, *counts, *distances, share(found.share), evidence]


@click.command(help=__doc__)
@click.option("--table", default=f"docs/{TABLE}", show_default=True, type=click.Path(exists=True, path_type=Path))
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), help="Folder of finished walks; none is kept.")
def main(table: Path, out: Path | None) -> None:
    """Walk, and write the results."""
    results = Results(read_rows(table.read_text(encoding="utf-8")))
    with TemporaryDirectory() as nowhere:
        tried = scan(results.best, out or Path(nowhere))
        grounds = placebo.walked(placebo.drawn(), out or Path(nowhere))
    folder = Path(__file__).parents[2] / "mjbiped" / "studies" / "reproduction" / "fits"
    (folder / GAINS_TABLE).write_text(write_tried(tried), encoding="utf-8")
    (folder / GROUNDS_TABLE).write_text(placebo.write_grounds(grounds), encoding="utf-8")
    text = json.dumps(sections(results, tried, grounds), indent=2, ensure_ascii=False)
    (folder / FITS).write_text(f"{text}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
