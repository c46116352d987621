"""Theorem 1, numerically: its constants on the limit cycle and along walks. See docs/stability.md.

python -m scripts.paper.theorem_1 --figure docs/images/theorem_1.png --tables docs/tables/stability
"""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import numpy as np
from tqdm.auto import tqdm

import mjbiped
from controllers import AdaptiveController
from mjbiped.analysis.error_dynamics import ESTIMATES, impact_gain, lyapunov_weights
from mjbiped.analysis.stability import Stability, stability
from mjbiped.plotting.comparison import plot_stability
from scripts.pages import TABLES, Table, show_table
from scripts.paper.cycle import cycle_stability, lyapunov_gain

TERRAINS = {
    "level": mjbiped.Terrain.level(),
    "slopes 0.3°": mjbiped.Terrain.slopes(),
    "mixed": mjbiped.Terrain.mixed(),
    "stairs −6 mm": mjbiped.Terrain.stairs(rise=-0.006),
    "stairs −6 cm": mjbiped.Terrain.stairs(rise=-0.06),
}
DRAWN = "mixed"
VARIANTS: dict[str, dict[str, Any]] = {
    "as in the paper": {},
    "without the update (27)": {"estimate_update": False},
    "without update and re-planning": {"estimate_update": False, "replanning_delay": None},
}
ALIKE = [(ground, "without the update (27)") for ground in ("level", "stairs −6 mm", "stairs −6 cm")]
"""Walks that are another one's twin: where the slope does not change, nothing is updated."""
NEVER_RIGHT = math.radians(3)
"""The estimate's error at the start of every walk, rad: without it an update that is exact leaves nothing to see."""


@click.command(help=__doc__)
@click.option("--figure", default="docs/images/theorem_1.png", show_default=True, type=click.Path(path_type=Path))
@TABLES
@click.option("--steps", default=60, show_default=True, type=click.IntRange(min=2), help="Steps per walk.")
def main(figure: Path, tables: Path | None, steps: int) -> None:
    """Walk, evaluate, draw and tabulate."""
    robot = mjbiped.Compass()
    gait = mjbiped.find_passive_gait(robot, math.radians(2))
    paper = AdaptiveController(robot, gait, initial_slope_estimate=NEVER_RIGHT)
    controllers = {name: replace(paper, **changes) for name, changes in VARIANTS.items()}
    found: dict[tuple[str, str], Stability] = {}
    pairs = [(ground, name) for ground in TERRAINS for name in VARIANTS if (ground, name) not in ALIKE]
    for ground, name in tqdm(pairs, desc="walks", disable=None):
        found[ground, name] = stability(
            mjbiped.walk(controllers[name], TERRAINS[ground], engine="hybrid", steps=steps, sample_period=2e-3)
        )
    plot_stability({name: found[DRAWN, name] for name in VARIANTS}, figure)
    show_table("on the limit cycle", *on_the_cycle(paper), tables, "cycle")
    show_table("along walks", *along_walks(found), tables, "walks")
    show_table("at touchdowns", *at_touchdowns(found), tables, "touchdowns")


def on_the_cycle(controller: AdaptiveController) -> Table:
    """Constants of the limit cycle, which depend on no terrain."""
    cycle = cycle_stability(controller)
    phi = cycle.evolution.transitions[-1]
    values, vectors = np.linalg.eigh(cycle.evolution.gramian)
    weak = math.degrees(math.atan2(abs(vectors[0, 0]), abs(vectors[1, 0])))
    gain, worst = controller.position_gain, impact_gain(controller.position_gain, cycle.alpha, cycle.beta)
    root = np.sqrt(lyapunov_weights(controller))
    jump = float(np.linalg.norm(root[:, None] * cycle.impact / root, 2)) ** 2
    whole = lyapunov_gain(controller, cycle.return_map)
    slowest = float(np.abs(cycle.multipliers[0]))
    mode = np.linalg.eig(cycle.return_map)
    slow = np.abs(mode.eigenvectors[ESTIMATES, np.argmax(np.abs(mode.eigenvalues))])
    left = phi[ESTIMATES, ESTIMATES]
    rows = [
        ("∫WWᵀdt over a step, eigenvalues", f"{values[1]:.1f}, {values[0]:.1f} 1/s³"),
        ("direction of the smaller one, from the cosine's axis", f"{weak:.1f}°"),
        ("‖Φ‖ over a step = least k_C e^(−λΔT)", f"{cycle.contraction:.3f}"),
        ("k_C, λ_α of (23), sharp at the step's end", f"{cycle.envelope.gain:.2f}, {cycle.envelope.rate:.2f} 1/s"),
        ("α, β of (19), to first order", f"{cycle.alpha:.2f} rad/s per rad, {cycle.beta:.3f}"),
        ("k_Δ of (20)", f"{worst:.2f}"),
        ("left side of (24)", f"{worst * cycle.contraction:.2f}"),
        ("the same with α = β = 0: √(2K₁² + 1) ‖Φ‖", f"{impact_gain(gain, 0.0, 0.0) * cycle.contraction:.2f}"),
        ("largest ‖z₁⁺‖/‖z₁⁻‖ at touchdown", f"{np.linalg.norm(cycle.impact[:2, :2], 2):.5f}"),
        ("largest ‖η⁺‖/‖η⁻‖ at touchdown", f"{np.linalg.norm(cycle.impact, 2):.2f}"),
        ("largest V_a(end)/V_a(start) of a step", f"{lyapunov_gain(controller, phi):.3f}"),
        ("largest V_a⁺/V_a⁻ at touchdown", f"{jump:.0f}"),
        ("largest V_a⁺/V_a⁺ from step to step", f"{whole:.3f}"),
        ("slowest multiplier of the return map of η", f"{slowest:.4f}"),
        ("its direction in (s̃, c̃), from the cosine's axis", f"{math.degrees(math.atan2(slow[0], slow[1])):.0f}°"),
        ("(s̃, c̃) after a step from (1, 0)", f"({left[0, 0]:.3f}, {left[1, 0]:.3f})"),
        ("the same from (0, 1)", f"({left[0, 1]:.3f}, {left[1, 1]:.3f})"),
        ("slowest multiplier where every step is re-planned", f"{np.abs(cycle.multipliers_replanned[0]):.4f}"),
    ]
    return ("on the limit cycle, any constant slope", "value"), rows


def along_walks(found: dict[tuple[str, str], Stability]) -> Table:
    """What became of (16), (24) and (26) on each walk."""
    rows = []
    for (ground, name), each in found.items():
        compared = each.ratio[np.isfinite(each.ratio)]
        rows.append(
            (
                ground,
                name,
                f"{np.abs(each.residual).max():.0e}",
                f"{np.abs(each.balance).max():.0e}",
                f"{each.excitation[:, 0].min():.1f} to {each.excitation[:, 0].max():.1f}",
                f"{each.contraction.min():.3f} to {each.contraction.max():.3f}",
                f"{np.nanmin(each.condition):.1f}",
                f"{each.condition_floor.min():.2f}",
                f"{int((compared < 1).sum())} of {compared.size}",
                f"{max(0.0, each.estimate_rise.max()):.1e}",
            )
        )
    headings = ("ground", "controller", "‖η⁻ − Φη⁺‖", "V_a balance", "weak eigenvalue", "‖Φ‖", "(24), least")
    return (*headings, "its floor", "(26) holds", "‖θ̃‖ rises by"), rows


def at_touchdowns(found: dict[tuple[str, str], Stability]) -> Table:
    """Jumps of V_a, on constant slope and at changes of slope, and what (20) says of them."""
    rows = []
    for (ground, name), each in found.items():
        changed = np.abs(each.slope_change) > 1e-9
        resolved = np.isfinite(each.impact_ratio)
        constant = each.lyapunov_jump[resolved & ~changed]
        at_change = each.lyapunov_jump[resolved & changed]
        beyond = each.impact_ratio[resolved] > each.impact_gain[resolved]
        rows.append(
            (
                ground,
                name,
                f"{int((constant > 0).sum())} of {constant.size}",
                f"{constant.max():.1e}" if constant.size else "–",
                f"{int((at_change > 0).sum())} of {at_change.size}",
                f"{at_change.max():.1e}" if at_change.size else "–",
                f"{each.impact_ratio[resolved].max():.3g}",
                f"{int(beyond.sum())} of {int(resolved.sum())}",
            )
        )
    headings = (
        "ground",
        "controller",
        "V_a rises, same slope",
        "greatest",
        "V_a rises, slope changes",
        "greatest there",
    )
    return (*headings, "‖η⁺‖/‖η⁻‖, largest", "beyond k_Δ of (20)"), rows


if __name__ == "__main__":
    main()
