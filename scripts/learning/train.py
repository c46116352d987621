"""Train a policy on random ground for some generations, or go on with a training that was stopped.

    python -m scripts.learning.train --task residual --seed 1 --generations 20
    python -m scripts.learning.train --task free --seed 1 --generations 50

The policy is saved as OUT/TASK-SEED.npz after every generation. The same command continues a training that was
stopped, until it has so many generations in all; remove the file to start again.
"""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import click
from rich.console import Console
from rich.table import Table
from tqdm.auto import tqdm

from mjbiped.errors import InputError
from scripts.learning.checkpoint import LAST, Checkpoint
from scripts.learning.commands import OUT, Command
from scripts.learning.training import train


@click.command(cls=Command, help=__doc__)
@click.option("--task", required=True, type=click.Choice(["residual", "free"]), help="What the policy's torques are.")
@click.option("--seed", default=1, show_default=True, type=click.IntRange(min=1), help="Of everything random.")
@click.option("--generations", required=True, type=click.IntRange(min=1), help="In all.")
@OUT
def main(task: str, seed: int, generations: int, out: Path) -> None:
    """Train, and say what was reached."""
    out.mkdir(parents=True, exist_ok=True)
    path, residual = out / f"{task}-{seed}.npz", task == "residual"
    before = reached = Checkpoint.load(path) if path.exists() else None
    if before and (before.residual, before.seed) != (residual, seed):
        raise InputError(f"{path} holds another training; remove it, or name another folder by --out")
    done = before.generations if before else 0
    if done:
        click.echo(f"{path}: {done} generations so far")
    with tqdm(total=generations, initial=done, desc=f"{task} {seed}", disable=None) as bar:
        for reached in islice(train(residual, seed, before), max(0, generations - done)):
            reached.save(path)
            bar.set_postfix_str(f"return {reached.mean_returns[-1].mean():.0f}", refresh=False)
            bar.update()
    assert reached is not None
    Console().print(summary(f"{task} policy, seed {seed}", reached))
    click.echo(f"wrote {path}")


def summary(title: str, reached: Checkpoint) -> Table:
    """What was reached, for people."""
    table = Table(title=title, show_header=False)
    for name, value in {
        "generations": f"{reached.generations}",
        "control periods walked": f"{reached.steps[-1] / 1e6:.2f} million",
        "wall time": f"{reached.wall[-1]:.0f} s",
        "processor time": f"{reached.processor[-1]:.0f} s",
        "return in the first generation": f"{reached.mean_returns[0].mean():.0f}",
        f"return in the last {min(LAST, reached.generations)}": f"{reached.last_return:.0f} (greatest possible: 1000)",
    }.items():
        table.add_row(name, value)
    return table


if __name__ == "__main__":
    main()
