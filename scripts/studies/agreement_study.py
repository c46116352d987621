"""How far both engines agree: the adaptive controller on every kind of ground and on random ones, as a table.

Differences are MuJoCo - hybrid engine. Where the walks part, the cause follows under the table. Then the greatest
differences at touchdowns on rough ground that nothing but the contact's resolution explains: what the limits in
`mjbiped/analysis/divergence.py` come from. Some four minutes. The result stands in `docs/tables/convergence.md`.

    python -m scripts.studies.agreement_study --tables docs/tables/convergence
    python -m scripts.studies.agreement_study --space 50 --tables docs/tables/three_dimensions

The second one walks a biped in space at physics steps of 0.1 ms, on ground that is drawn: slopes ahead and to the side
with steps, or bumps on a slope; the result stands on docs/three_dimensions.md.
"""

import math
from dataclasses import replace
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray
from tqdm.auto import tqdm

import mjbiped
from controllers import AdaptiveController
from mjbiped.analysis import divergence
from mjbiped.analysis.compare import torque_differences
from mjbiped.control.registry import make_controller
from mjbiped.records import measures
from scripts.pages import TABLES, show_rows, show_table
from scripts.studies.gallery import ADAPTIVE, TERRAINS

ROUNDING = 1e-6
"""Shares of a limit below which a difference is no property of the engines."""

FIRST_SEED, QUANTILES = 2000, (0.5, 0.9, 0.99, 1.0)
STATES = {
    "q_before": "angles before the impact", "dq_before": "rates before the impact", "q": "angles", "dq": "rates",
}  # fmt: skip
"""Columns of a touchdown that are compared in space, with their titles."""


def row(name: str, walked: mjbiped.Comparison) -> dict[str, str]:
    """Cells of a ground; of torque, step length and estimate the greatest difference at any time or touchdown."""
    there, here = walked.mujoco, walked.hybrid
    n = len(walked.touchdowns["x"])
    lengths = measures.step_lengths(there)[:n] - measures.step_lengths(here)[:n]
    _, torque = torque_differences(walked)
    ankle, hip = there.peak_torque - here.peak_torque
    return {
        "ground": name + ("" if walked.divergence is None else " *"),
        "c_mt hybrid": f"{here.cost_of_transport:.6f}",
        "c_mt %": f"{100 * (there.cost_of_transport / here.cost_of_transport - 1):+.2f}",
        "peak ankle, hip N m": f"{ankle:+.3f}, {hip:+.3f}",
        "torque N m": f"{np.nanmax(np.abs(torque)):.3f}",
        "step mm": f"{1e3 * np.abs(lengths).max():.3f}",
        "estimate deg": f"{math.degrees(np.abs(walked.touchdowns['slope_estimate']).max()):.4f}",
        "distance mm": f"{1e3 * (there.distance - here.distance):+.2f}",
    }


def resolved(walked: mjbiped.Comparison, controller: AdaptiveController) -> int:
    """Touchdowns before the first one at which something else than the contact's resolution parts the walks."""
    there, here = walked.mujoco, walked.hybrid
    n = len(walked.touchdowns["x"])
    return next((k for k in range(n) if any(divergence.explanations(there, here, k, controller))), n)


def greatest(controller: AdaptiveController, count: int, steps: int) -> tuple[list[list[str]], int]:
    """Greatest differences on so many rough grounds, their limits, and at how many touchdowns they were looked for."""
    shares = {name: [np.zeros(0)] for name in divergence.COLUMNS}
    values = {name: [np.zeros(0)] for name in divergence.COLUMNS}
    for seed in tqdm(range(count), desc="rough terrains", disable=None):
        terrain = mjbiped.Terrain.random(seed=seed + 1000, roughness=0.001 * (1 + seed % 3))
        walked = mjbiped.compare(ADAPTIVE, terrain, steps=steps)
        n = resolved(walked, controller)
        for name in divergence.COLUMNS:
            difference = np.abs(np.nan_to_num(walked.touchdowns[name][:n]))
            values[name].append(difference)
            shares[name].append(difference / walked.touchdowns[f"limit_{name}"][:n])
    rows = []
    for name, column in divergence.COLUMNS.items():
        factor, unit = divergence.DISPLAYED[column.unit]
        most = factor * np.concatenate(values[name])
        rows.append(
            [
                column.meaning,
                f"{np.median(most):.2g} {unit}",
                f"{np.percentile(most, 99):.2g} {unit}",
                f"{most.max():.2g} {unit}",
                _ratio(np.concatenate(shares[name]).max()),
            ]
        )
    return rows, len(np.concatenate(values["x"]))


def in_space(seed: int) -> mjbiped.Terrain:
    """Ground for a biped in space: bumps on a slope where the seed is odd, else segments that fall to both sides."""
    draw = np.random.default_rng(FIRST_SEED + seed)
    if seed % 2:
        slope, lateral = np.radians(draw.uniform([-2.0, -1.5], [2.0, 1.5])).tolist()
        ground = mjbiped.Terrain.bumps(rms=float(draw.uniform(0.002, 0.01)), seed=FIRST_SEED + seed)
        return replace(ground, angle=(slope,), lateral=(lateral,))
    ground = mjbiped.Terrain.random(seed=FIRST_SEED + seed, rise=(-0.02, 0.02))
    falls = np.radians(draw.uniform(-2.0, 2.0, len(ground.x) - 1))
    return replace(ground, lateral=(0.0, *falls.tolist()))


def in_both(seed: int, steps: int) -> tuple[dict[str, str], dict[str, NDArray[np.float64]]]:
    """A row of the table, and how far the states at each touchdown are apart in shares of their size."""
    law = make_controller("adaptive", mjbiped.Compass3D(), {})
    contacts, ground = mjbiped.Mujoco(timestep=1e-4, control_period=1e-3), in_space(seed)
    walked = mjbiped.compare(law, ground, steps=steps, mujoco=contacts)
    there, here = walked.mujoco, walked.hybrid
    n, apart = len(walked.touchdowns["x"]), {}
    for name in STATES:
        one, other = there.touchdowns[name][:n], here.touchdowns[name][:n]
        apart[name] = np.linalg.norm(one - other, axis=1) / np.linalg.norm(other, axis=1)
    row = {
        "ground": f"{ground.name} {seed}", "MuJoCo": there.outcome, "hybrid": here.outcome,
        "c_mt hybrid": f"{here.cost_of_transport:.5f}",
        "c_mt %": f"{100 * (there.cost_of_transport / here.cost_of_transport - 1):+.2f}",
        **{f"{title}, greatest %": f"{100 * apart[name].max():.2f}" for name, title in STATES.items()},
        "where they part": "" if walked.divergence is None else walked.verdict,
    }  # fmt: skip
    return row, apart


def walk_in_space(count: int, steps: int, tables: Path | None) -> None:
    """Walk on so many grounds in both engines, and tell the quantiles of the differences."""
    rows, shares = zip(*(in_both(seed, steps) for seed in tqdm(range(count), disable=None)), strict=True)
    show_rows(f"Compass3D, {steps} steps, MuJoCo - hybrid engine", rows, tables, "agreement")
    cost = np.array([abs(float(row["c_mt %"])) for row in rows]) / 100.0
    values = {"c_mt": cost} | {title: np.concatenate([s[name] for s in shares]) for name, title in STATES.items()}
    quantiles = [
        [title, f"{len(each)}", *(f"{100 * np.quantile(each, q):.2f}" for q in QUANTILES)]
        for title, each in values.items()
    ]
    headings = ("difference %", "number", *(f"{100 * q:g} %" for q in QUANTILES))
    show_table("Quantiles of the differences", headings, quantiles, tables, "agreement quantiles")


def _ratio(share: float) -> str:
    """How many times the greatest difference the limit is, but of a difference that is rounding alone."""
    return f"{1.0 / share:.1f} ×" if share > ROUNDING else "rounding"


@click.command(help=__doc__)
@click.option("--steps", default=20, show_default=True, type=click.IntRange(min=1), help="Steps per walk.")
@click.option("--random", "count", default=30, show_default=True, type=click.IntRange(min=0), help="Random terrains.")
@click.option("--rough", default=138, show_default=True, type=click.IntRange(min=1), help="Grounds for the limits.")
@click.option("--rough-steps", default=12, show_default=True, type=click.IntRange(min=1), help="Steps on each.")
@click.option("--space", default=0, type=click.IntRange(min=0), help="Walk in space instead, on so many grounds.")
@TABLES
def main(steps: int, count: int, rough: int, rough_steps: int, space: int, tables: Path | None) -> None:
    """Walk on all terrains and print the table."""
    if space:
        walk_in_space(space, steps, tables)
        return
    terrains = {name: terrain for name, terrain in TERRAINS.items() if name != "rough"}
    for seed in range(count):
        terrains[f"random {seed}"] = mjbiped.Terrain.random(seed=seed, roughness=0.002 * (seed % 3))
    rows, partings = [], []
    for name, terrain in tqdm(terrains.items(), desc="terrains", disable=None):
        walked = mjbiped.compare(ADAPTIVE, terrain, steps=steps)
        rows.append(row(name, walked))
        if walked.divergence is not None:
            partings.append([name, walked.verdict])
    show_rows(f"MuJoCo - hybrid engine, {steps} steps; * they part", rows, tables, "agreement")
    show_table("where they part", ("ground", "where and why"), partings, tables, "partings")
    rows_of_limits, touchdowns = greatest(ADAPTIVE, rough, rough_steps)
    headings = ("difference", "median", "99 %", f"greatest of {touchdowns} touchdowns", "limit : greatest")
    show_table(f"{rough} rough terrains, {rough_steps} steps", headings, rows_of_limits, tables, "limits")


if __name__ == "__main__":
    main()
