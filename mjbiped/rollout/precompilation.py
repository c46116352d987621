"""Machine code made in advance, so that no walk of a registered controller has to wait for it."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import as_completed

from mjbiped.control.controller import Controller
from mjbiped.control.loading import is_reference
from mjbiped.control.registry import controller_class, controller_names, make_controller, settings_of
from mjbiped.engines.base import ENGINES
from mjbiped.errors import InputError
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot
from mjbiped.rollout.walk import walk
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.domains import known_name
from mjbiped.utils.parallel import cores, processes, progress_bar

Unit = tuple[str, str, Robot]
"""Names of an engine and of a controller, and a robot of the kind that is walked."""

_ROBOTS: tuple[Robot, ...] = (KneedBiped(), Compass())  # what takes longest first


def precompile(
    controllers: Sequence[str] | None = None,
    *,
    engines: Sequence[str] | None = None,
    workers: int | None = None,
    progress: bool = True,
) -> dict[str, list[str]]:
    """Compile the laws and engines that walks of controllers need, in parallel processes.

    Machine code depends on the kinds of robot and of a controller's settings, not on their values, nor on the terrain.
    What is cached on disk already costs a second or two.

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
    units = [
        (engine, name, robot)
        for robot in _ROBOTS
        for engine in chosen
        for name in names
        if controller_class(name, robot).drives(robot)
    ]
    for name in {*names} - {name for _, name, _ in units}:
        joints = ", or ".join(" and ".join(robot.joints) for robot in _ROBOTS)
        raise InputError(f"{name} drives {' and '.join(controller_class(name).joints)}: robots have {joints}")
    # an engine's machine code serves many controllers: one of them makes it, then the others come
    first = [*{unit[0]: unit for unit in reversed(units)}.values()]
    failures: list[InputError] = []
    with (
        processes(min(workers or cores(), len(units))) as pool,
        progress_bar(total=len(units), desc="compiling", unit="law", progress=progress) as bar,
    ):
        for group in (first, [unit for unit in units if unit not in first]):
            for done in as_completed([pool.submit(_walk_a_step, unit) for unit in group]):
                bar.update()
                try:
                    done.result()
                except InputError as error:
                    failures.append(error)
    if failures:
        raise failures[0]
    return dict.fromkeys(chosen, names)


def _walk_a_step(unit: Unit) -> None:
    """Walk one step in a process of its own, which compiles all code that the walk needs, and tests it."""
    engine, name, robot = unit
    given = {"imitate_slope_deg": 2.5} if "imitate_slope_deg" in settings_of(name, robot) else {}
    walk(make_controller(name, robot, given), Terrain.incline(2.5), engine=engine, robot=robot, steps=1, progress=False)
