"""Touchdowns of feet that are bodies, in MuJoCo: slaps, friction, and how far rates are from the impact map's.

Forty steps from three phases on eight of the grounds of `soles_study`, with the law that supervises itself, on soles of
12 cm behind and ahead of the ankle. Five minutes on two cores. The table stands in docs/tables/footed.md.

    python -m scripts.studies.footed_touchdowns_study --tables docs/tables/footed
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import click
import numpy as np
from tqdm.auto import tqdm

import mjbiped
from controllers import SupervisedController
from mjbiped.records import measures
from mjbiped.records.measures import FINISHED
from scripts.pages import TABLES, show_rows
from scripts.studies.footed_study import PHASES, impact_errors, robots
from scripts.studies.soles_study import STEPS, grounds
from scripts.studies.supervised_study import CLEARANCE

HALF = 0.12  # m: the sole behind the ankle, and ahead of it
KINDS = ("level", "3° up", "3° down", "changes of ±3°", "stairs +4 cm", "stairs −4 cm", "mixed", "treads, 2 cm")
CHANGED = 1e-3  # rad: a foothold whose slope differs from the one before by more; feet stand flat within less


def slaps(walk: mjbiped.Walk) -> list[float]:
    """How long heel and toe of a landing foot were apart, ms, at the touchdowns on another slope than before."""
    slope = walk.touchdowns["slope"]
    changed = np.abs(np.diff(slope, prepend=0.0)) > CHANGED
    return [1e3 * float(value) for value in walk.touchdowns["slap"][changed]]


def told(walks: Sequence[mjbiped.Walk]) -> dict[str, str]:
    """The cells of one ground, of the touchdowns of the walks that made all steps."""
    whole = [walk for walk in walks if walk.outcome == "finished"]
    through = sum(measures.summary(walk)["verdict"] == FINISHED for walk in walks)
    shares = {"all steps": f"{len(whole)} of {len(walks)}", "through": f"{through} of {len(walks)}"}
    if not whole:
        return shares
    errors = [100 * error for walk in whole for error in impact_errors(walk)]
    friction = max(float(walk.touchdowns["friction"].max()) for walk in whole)
    slapped = [value for walk in whole for value in slaps(walk)]
    return shares | {
        "friction": f"{friction:.2f}",
        "touchdowns": str(len(errors)),
        "slap where the slope changes, ms": f"{min(slapped):.1f} to {max(slapped):.1f}" if slapped else "–",
        "impact map: median, %": f"{np.quantile(errors, 0.5):.2g}",
        "quantile of 95 %, %": f"{np.quantile(errors, 0.95):.2g}",
        "greatest, %": f"{max(errors):.2g}",
    }


@click.command(help=__doc__)
@TABLES
def main(tables: Path | None) -> None:
    """Walk, print, and write what was asked for."""
    gait = mjbiped.find_reference(mjbiped.Compass(sole=(HALF, HALF)), clearance=CLEARANCE, retraction=False)
    made = {name: ground for name, ground in grounds() if name in KINDS}
    feet = [(name, robot) for name, engine, robot in robots(HALF) if engine == "mujoco"]
    rows: list[dict[str, str]] = []
    with tqdm(total=len(feet) * len(made), mininterval=30.0 if not sys.stderr.isatty() else 0.1) as bar:
        for name, robot in feet:
            law = SupervisedController(robot, gait)
            for kind, ground in made.items():
                terrains = [ground(phase) for phase in PHASES]
                walks = mjbiped.walk_many(law, terrains, engine="mujoco", steps=STEPS)
                rows.append({"foot": name, "ground": kind, **told(walks)})
                bar.update()
    show_rows("feet with mass: touchdowns", rows, tables, "touchdowns of feet")


if __name__ == "__main__":
    main()
