"""How true the contacts are: the timestep against the analytic passive gait, as a table.

The passive robot walks down 2 degrees in MuJoCo, once per timestep. Its mean step length and period over the last half
of the steps are compared with the limit cycle, and every impact with the impact map (2). `docs/physics.md` quotes the
slip.

    python -m scripts.studies.contact_study --steps 60
"""

import click
import numpy as np
from tqdm.auto import tqdm

import mjbiped
from controllers import PassiveController
from mjbiped.records import measures
from scripts.pages import show_rows
from scripts.studies.gallery import GAIT

TIMESTEPS = (2e-3, 1e-3, 5e-4, 2e-4, 1e-4)


def row(timestep: float, steps: int) -> dict[str, str]:
    """Errors of one walk: step length and period, impact (mean and worst), slip, penetration."""
    walk = mjbiped.walk(
        PassiveController(), mjbiped.Terrain.incline(2.0), steps=steps, engine=mjbiped.Mujoco(timestep=timestep)
    )
    outcome = walk.outcome if walk.outcome == "finished" else f"{walk.outcome} after {walk.steps}"
    last, walked = max(1, walk.steps // 2), {"timestep s": f"{timestep:.0e}", "outcome": outcome}
    if not walk.steps:
        return walked
    impact = np.abs(measures.impact_errors(walk)).max(axis=1)
    return walked | {
        "step length %": f"{100 * (measures.step_lengths(walk)[-last:].mean() / GAIT.step_length - 1):+.3f}",
        "period %": f"{100 * (measures.step_periods(walk)[-last:].mean() / GAIT.period - 1):+.3f}",
        "impact mean %": f"{100 * impact.mean():.3f}",
        "impact worst %": f"{100 * impact.max():.3f}",
        "slip mm": f"{1e3 * walk.touchdowns['slip'].max():.3f}",
        "penetration mm": f"{1e3 * walk.touchdowns['penetration'].max():.3f}",
    }


@click.command(help=__doc__)
@click.option("--steps", default=60, show_default=True, type=click.IntRange(min=2), help="Steps per walk.")
def main(steps: int) -> None:
    """Run all timesteps and print the table."""
    rows = [row(timestep, steps) for timestep in tqdm(TIMESTEPS, desc="timesteps", disable=None)]
    show_rows(f"passive walk down 2 degrees, {steps} steps", rows)


if __name__ == "__main__":
    main()
