"""Train a policy on random ground for some minutes, or go on with a training that was broken off.

    python -m scripts.learning.train --task residual
    python -m scripts.learning.train --task free

The policy stands in OUT/TASK.npz after every generation. A training that was broken off goes on from there, until it
has taken the minutes in all; remove the file to begin anew.
"""

from __future__ import annotations

from pathlib import Path

import click
from rich.console import Console
from rich.table import Table
from tqdm.auto import tqdm

from mjbiped.errors import InputError
from scripts.learning.checkpoint import Checkpoint
from scripts.learning.commands import FOLDER, Command
from scripts.learning.training import train

SEED = 1


@click.command(cls=Command, help=__doc__)
@click.option("--task", required=True, type=click.Choice(["residual", "free"]), help="What the policy's torques are.")
@click.option("--minutes", default=10.0, show_default=True, type=click.FloatRange(min=0, min_open=True), help="In all.")
@FOLDER
def main(task: str, minutes: float, out: Path) -> None:
    """Train, and say what was reached."""
    out.mkdir(parents=True, exist_ok=True)
    path, residual = out / f"{task}.npz", task == "residual"
    before = Checkpoint.load(path) if path.exists() else None
    if before and (before.residual, before.seed) != (residual, SEED):
        raise InputError(f"{path} holds another training; remove it, or name another folder by --out")
    seconds, done = 60.0 * minutes, 0.0 if before is None else float(before.wall[-1])
    if before is not None:
        click.echo(f"{path}: {before.generations} generations in {done:.0f} s so far")
    reached = before
    if done < seconds:
        form = "{l_bar}{bar}| {n:.0f}/{total:.0f} s{postfix}"
        with tqdm(total=seconds, initial=done, desc=task, bar_format=form, disable=None) as bar:
            for reached in train(residual, SEED, before):
                reached.save(path)
                bar.set_postfix_str(f"return {reached.mean_returns[-1].mean():.0f}", refresh=False)
                bar.update(min(float(reached.wall[-1]), seconds) - bar.n)
                if reached.wall[-1] >= seconds:
                    break
    assert reached is not None
    Console().print(summary(task, reached))
    click.echo(f"wrote {path}")


def summary(task: str, reached: Checkpoint) -> Table:
    """What was reached, for people."""
    last = reached.mean_returns[-10:]
    table = Table(title=f"{task} policy", show_header=False)
    for name, value in {
        "generations": f"{reached.generations}",
        "control periods walked": f"{reached.steps[-1] / 1e6:.2f} million",
        "wall time": f"{reached.wall[-1]:.0f} s",
        "processor time": f"{reached.processor[-1]:.0f} s",
        "return in the first generation": f"{reached.mean_returns[0].mean():.0f}",
        f"return in the last {len(last)}": f"{last.mean():.0f} (greatest possible: 1000)",
    }.items():
        table.add_row(name, value)
    return table


if __name__ == "__main__":
    main()
