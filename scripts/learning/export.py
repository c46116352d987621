"""Write a trained policy as the text that `--controller policy` walks by.

python -m scripts.learning.export --policy scripts/learning/policies/free-3.npz
"""

from __future__ import annotations

from pathlib import Path

import click

from mjbiped.controllers.policy import FEATURES, STORED
from mjbiped.errors import InputError
from mjbiped.utils.files import saved
from scripts.learning.checkpoint import Checkpoint
from scripts.learning.commands import Command


@click.command(cls=Command, help=__doc__)
@click.option(
    "--policy",
    required=True,
    type=click.Path(dir_okay=False, path_type=Path),
    help="File of a free policy, which scripts.learning.train wrote.",
)
@click.option("--out", default=STORED, show_default=False, type=click.Path(path_type=Path), help="The text.")
def main(policy: Path, out: Path) -> None:
    """Read, and write."""
    with saved(out) as unfinished:
        unfinished.write_text(written(Checkpoint.load(policy)), encoding="utf-8")
    click.echo(f"wrote {out}")


def written(training: Checkpoint) -> str:
    """The text of a policy.

    Raises:
        InputError: It is a residual, which walks with the adaptive controller alone.
    """
    if training.residual:
        raise InputError("a residual policy adds to the adaptive controller's torques; give a free one")
    told = (
        f"free policy of seed {training.seed} after {training.generations} generations: {training.last_return:.0f} of "
        "1000 on its last forty grounds",
        f"python -m scripts.learning.train --task free --seed {training.seed} --generations {training.generations}",
        "rows: ankle, its change with time; hip, its change with time",
        f"columns: {', '.join(FEATURES)}",
    )
    rows = training.weights.reshape(-1, len(FEATURES)).tolist()
    return "".join([*(f"# {line}\n" for line in told), *(",".join(map(repr, row)) + "\n" for row in rows)])


if __name__ == "__main__":
    main()
