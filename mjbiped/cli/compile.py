"""The command `mjbiped compile`: machine code made in advance."""

from __future__ import annotations

import click

from mjbiped.cli import options, sections
from mjbiped.cli.files import tell
from mjbiped.engines.names import ENGINES
from mjbiped.utils import domains


@click.command("compile", cls=sections.SectionCommand)
@click.argument("controllers", nargs=-1)
@sections.options(
    "Machine code",
    ("--engine", click.Choice(tuple(ENGINES)), None, "For this engine alone; for all unless given."),
    ("--workers", domains.WORKERS, None, "Processes; one for each core unless given."),
)
@options.printed_options
def compile_(controllers: tuple[str, ...], engine: str | None, workers: int | None, json: bool, quiet: bool) -> None:
    """Compile what walks of the CONTROLLERS (all that are registered) need, so that none has to wait for it.

    One of your own is named by its class, as for `mjbiped walk`.

    The machine code is kept beside the package, else in the user's cache, or in the folder that the environment
    variable NUMBA_CACHE_DIR names: set it for an image or a cluster, here and where the walks are made. It is for one
    kind of processor and one version of the project. What is there already is not compiled again.

    \b
    Examples:
      mjbiped compile
      mjbiped compile adaptive passive --engine hybrid
      mjbiped compile spread.py:HipSpread
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.rollout.precompilation import precompile

    engines = None if engine is None else (engine,)
    made = precompile(controllers or None, engines=engines, workers=workers, progress=not quiet)
    lines = [f"compiled for the {name} engine: {', '.join(names)}" for name, names in made.items()]
    tell({"compiled": made}, lines, (), json=json, quiet=quiet)
