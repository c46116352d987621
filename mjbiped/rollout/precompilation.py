"""Machine code made in advance, so that no walk of a registered controller has to wait for it."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait

from tqdm.auto import tqdm

from mjbiped.control.controller import Controller
from mjbiped.control.own import is_reference
from mjbiped.control.registry import controller_class, controller_names, make_controller
from mjbiped.engines.names import ENGINES
from mjbiped.errors import InputError
from mjbiped.robots.compass import Compass
from mjbiped.rollout.walk import walk
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.domains import known_name
from mjbiped.utils.parallel import cores, processes
from mjbiped.utils.progress import hidden

Unit = tuple[str, str]
"""Names of an engine and of a controller."""


def precompile(
    controllers: Sequence[str] | None = None,
    *,
    engines: Sequence[str] | None = None,
    workers: int | None = None,
    progress: bool = True,
) -> dict[str, list[str]]:
    """Compile what walks of controllers need, in processes side by side; what is on disk already costs a second or two.

    Machine code depends on the kinds of a controller's settings, not on their values, and on neither robot nor terrain.

    Args:
        controllers: Names of controllers, registered or a user's own; unless given, all that are registered.
        engines: Names of engines; unless given, both.
        workers: Number of processes; one for each core unless given.
        progress: Whether to show a progress bar.

    Returns:
        The names of the controllers by engine.

    Raises:
        InputError: A name is unknown, or a controller's laws cannot be compiled; the others are compiled then.
    """
    names = list(controllers or controller_names())
    for name in names:
        if is_reference(name) and controller_class(name).law is Controller.law:
            raise InputError(
                f"{name} is plain Python, of which no machine code is made: it has no law() (docs/controller.md shows "
                "one)"
            )
    chosen = [known_name("engine", name, ENGINES) for name in engines or sorted(ENGINES)]
    # an engine's machine code serves many controllers: one of them makes it, then the others come
    waiting: dict[tuple[str, int], list[Unit]] = {}
    for name in names:
        states = len(controller_class(name).states)
        for engine in chosen:
            waiting.setdefault((engine, ENGINES[engine].room(states)), []).append((engine, name))
    failures: list[InputError] = []
    total = len(names) * len(chosen)
    with (
        processes(min(workers or cores(), total)) as pool,
        tqdm(total=total, desc="compiling", unit="law", disable=hidden(progress)) as bar,
    ):
        running: dict[Future[None], tuple[str, int] | None] = {
            pool.submit(_walk_a_step, group.pop(0)): kind for kind, group in sorted(waiting.items())
        }
        while running:
            for done in wait(running, return_when=FIRST_COMPLETED).done:
                kind = running.pop(done)
                bar.update()
                for unit in waiting.pop(kind) if kind is not None else ():
                    running[pool.submit(_walk_a_step, unit)] = None
                try:
                    done.result()
                except InputError as error:
                    failures.append(error)
    if failures:
        raise failures[0]
    return dict.fromkeys(chosen, names)


def _walk_a_step(unit: Unit) -> None:
    """In a process of its own: a walk of one step compiles all that it needs, and shows that it works."""
    engine, name = unit
    walk(make_controller(name, Compass(), {}), Terrain.incline(2.0), engine=engine, steps=1, progress=False)
