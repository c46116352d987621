"""Theorem 1, numerically: its constants on the limit cycle and along walks. See docs/stability.md.

python -m scripts.paper.theorem_1 --figure docs/images/theorem_1.png --tables docs/tables/stability
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import click
import numpy as np
from numpy.typing import NDArray
from tqdm.auto import tqdm

import mjbiped
from controllers import AdaptiveController
from mjbiped.analysis.error_dynamics import (
    ESTIMATES,
    SIZE,
    Evolution,
    evolve,
    impact_gain,
    impact_matrix,
    lyapunov_weights,
)
from mjbiped.analysis.stability import Stability, stability
from mjbiped.control.tracking import AdaptiveTracking
from mjbiped.gaits.cycle import eigenvalues
from mjbiped.plotting.comparison import plot_stability
from mjbiped.robots.compass import Array
from scripts.pages import TABLES, Table, show_table


class Envelope(NamedTuple):
    """The bound (23) of the norm of Phi over a step, gain exp(-rate (t - t_0)), which is sharp at its end.

    Attributes:
        gain: k_C.
        rate: lambda_alpha, 1/s.
    """

    gain: float
    rate: float


def envelope(time: Array, transitions: Array) -> Envelope:
    """The bound (23) with the smallest k_C among those whose value at the end is the norm of Phi there.

    No other pair of constants makes the left side of (24) smaller, for none can be below the norm itself.

    Args:
        time: Shape (n,), s.
        transitions: Phi(t, t_0) at them, shape (n, 6, 6).
    """
    logs = np.log(np.linalg.norm(transitions, 2, axis=(1, 2)))
    left = time[-1] - time[:-1]
    rate = float(np.max((logs[:-1] - logs[-1]) / left))
    return Envelope(math.exp(logs[-1] + rate * (time[-1] - time[0])), rate)


@dataclass(frozen=True, eq=False)
class CycleStability:
    """What becomes of small errors on the limit cycle, on ground of any constant slope.

    The cycle's angles are measured from the ground, and so is all of (22): nothing here depends on the slope.

    Attributes:
        evolution: Of (22) over a period, with q = q_r.
        envelope: The constants of (23).
        impact: eta after a touchdown from eta before it, to first order, shape (6, 6). The touchdown comes when the
            swing foot meets the ground, not when the reference would: the error moves it in time.
        alpha: Of (19), to first order: how the error of the angles makes one of the rates.
        beta: Of (19): norm of the impact map.
        return_map: eta after a touchdown from eta after the one before it, shape (6, 6).
    """

    evolution: Evolution
    envelope: Envelope
    impact: Array
    alpha: float
    beta: float
    return_map: Array

    def __repr__(self) -> str:
        """One line; the matrices are long."""
        largest = abs(self.multipliers[0])
        return f"<CycleStability: contraction {self.contraction:.6g} a step, largest multiplier {largest:.6g}>"

    @property
    def contraction(self) -> float:
        """Norm of Phi over the period: the sharp k_C exp(-lambda T) of (23)."""
        return float(np.linalg.norm(self.evolution.transitions[-1], 2))

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """Eigenvalues of the return map, largest modulus first; the loop is stable where all lie in the unit circle."""
        return eigenvalues(self.return_map)

    @property
    def multipliers_replanned(self) -> NDArray[np.complex128]:
        """Multipliers of the estimates alone: with re-planning each step begins without tracking error."""
        return eigenvalues(self.evolution.transitions[-1][ESTIMATES, ESTIMATES])


def cycle_stability(controller: AdaptiveTracking, intervals: int = 200) -> CycleStability:
    """Theorem 1's constants on the limit cycle, where they depend on robot, gait and gains alone.

    Args:
        controller: The law; its re-planning and its update (27) do not act in the neighbourhood of the cycle.
        intervals: Of the period; the error is of fourth order in their width.
    """
    gait = controller.gait
    time = np.linspace(0.0, gait.period, intervals + 1)
    q, dq, ddq = gait.reference(time)
    evolution = evolve(controller, time, q, dq)
    phi = evolution.transitions[-1]
    impact, alpha, beta = _impact(controller, q[-1], dq[-1], ddq[-1])
    return CycleStability(evolution, envelope(time, evolution.transitions), impact, alpha, beta, impact @ phi)


def _impact(controller: AdaptiveTracking, q: Array, dq: Array, ddq: Array) -> tuple[Array, float, float]:
    """First-order map of eta at a touchdown of the cycle, whose state before it is q, dq, ddq; alpha and beta of (19).

    The robot is at q - z1 and meets the ground later by t with sum(q + dq t - z1) = 0; the reference begins anew.
    """
    constants = controller.robot.constants
    swap = np.array([[0.0, 1.0], [1.0, 0.0]])
    delay = np.array([1.0, 1.0]) / dq.sum()  # t per z1
    moved = np.outer(dq, delay) - np.eye(2)  # of the posture at touchdown, per z1
    hit = impact_matrix(constants, q)
    step = 1e-5  # central differences: truncation and rounding both some 1e-10
    turn = np.column_stack(
        [
            (impact_matrix(constants, q + step * unit) - impact_matrix(constants, q - step * unit)) @ dq / (2 * step)
            for unit in np.eye(2)
        ]
    )
    z1_z1 = -swap @ moved
    dz1_z1 = -(turn @ moved + hit @ np.outer(ddq, delay))
    gain = controller.position_gain
    result = np.eye(SIZE)
    # z2 = dz1 + K1 z1 on both sides
    result[0:2, 0:2], result[0:2, 2:4] = z1_z1, 0.0
    result[2:4, 0:2] = gain * z1_z1 + dz1_z1 - gain * hit
    result[2:4, 2:4] = hit
    return result, float(np.linalg.norm(dz1_z1, 2)), float(np.linalg.norm(hit, 2))


def lyapunov_gain(controller: AdaptiveTracking, transition: Array) -> float:
    """Largest V_a at the end of a stretch over V_a at its start, of all first errors; at most 1 by (17)."""
    root = np.sqrt(lyapunov_weights(controller))
    return float(np.linalg.norm(root[:, None] * transition / root, 2)) ** 2


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
