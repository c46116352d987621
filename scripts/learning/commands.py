"""What the programs of this folder have in common on the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from mjbiped.cli.main import INTERRUPTED, end, terminable
from mjbiped.errors import MjbipedError

OUT = click.option(
    "--out",
    default=Path("out/learning"),
    show_default=True,
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder of what is made.",
)


class Command(click.Command):
    """Turns what is a user's to mend, and Ctrl-C, into a line and an exit status, as mjbiped's own commands do."""

    def __init__(self, name: str | None, *, help: str = "", **settings: Any) -> None:
        """Make the command; indented lines of its help stay lines."""
        super().__init__(name, help=help.replace("\n\n    ", "\n\n\b\n    "), **settings)

    def invoke(self, ctx: click.Context) -> Any:
        """Run it."""
        with terminable():
            try:
                return super().invoke(ctx)
            except MjbipedError as error:
                end(2, str(error))
            except KeyboardInterrupt:
                end(INTERRUPTED, "interrupted")
