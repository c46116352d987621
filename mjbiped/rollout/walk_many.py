"""`walk_many()`: simulate many walks at once, each bitwise as if alone; see docs/studies.md."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from numbers import Real
from typing import Any, Literal, TypeAlias, TypedDict, Unpack, overload

from mjbiped.control.controller import Controller
from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.engines.base import Engine, engine_of
from mjbiped.engines.plan import DEFAULT_SAMPLE_PERIOD, Plan, Terms, make_plan
from mjbiped.errors import GaitError, InputError, MjbipedError
from mjbiped.records.record import Walk
from mjbiped.robots.robot import Robot
from mjbiped.rollout.batch import Batch, Result
from mjbiped.rules.scuffing import ScuffingRule, chosen
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.domains import WORKERS, entries
from mjbiped.utils.parallel import cores
from mjbiped.utils.progress import progress_bar

Initial: TypeAlias = str | Sequence[float]


class _Broken(BaseException):
    """Many walks of which some were broken off.

    Attributes:
        walks: Record or summary of each walk, in order; of a broken walk the part so far, with the outcome
            "interrupted", or None if it could not begin.
        errors: Error messages, by the walk's index in that list.
    """

    def __init__(self, message: str, walks: Sequence[Result | None], errors: Mapping[int, str]) -> None:
        """Make the exception from its message, the walks so far and their errors."""
        super().__init__(message)
        self.walks = walks
        self.errors = errors


class WalksStopped(_Broken, MjbipedError):  # noqa: N818 (as its sisters of one walk)
    """Some of many walks were broken off by an error; the others have been walked to their ends.

    `walks` has the record or summary of each walk in order, of a broken walk the part so far, or None if it could not
    begin; `errors` has the messages by the walk's index in that list.
    """


class WalksInterrupted(_Broken, KeyboardInterrupt):
    """Many walks were broken off by Ctrl-C; what was recorded is not lost.

    `walks` has the record or summary of each walk in order: one that was under way in a thread has the outcome
    "interrupted", one that was under way in another process or had not begun is None. `errors` has the messages of
    walks that had failed before.
    """


class _Options(TypedDict, total=False):
    """Keyword arguments that the overloads of `walk_many` have in common."""

    engine: str | Engine
    steps: int | None
    distance: float | None
    initial: Initial | Sequence[Initial]
    robot: Robot | None
    sample_period: float | None
    scuffing: ScuffingRule | None
    disturbances: Disturbances | Sequence[Disturbances] | None
    workers: int | None
    progress: bool


@overload
def walk_many(
    controllers: Controller | Iterable[Controller],
    terrains: Terrain | Iterable[Terrain],
    *,
    summaries: Literal[False] = ...,
    **options: Unpack[_Options],
) -> list[Walk]: ...


@overload
def walk_many(
    controllers: Controller | Iterable[Controller],
    terrains: Terrain | Iterable[Terrain],
    *,
    summaries: Literal[True],
    **options: Unpack[_Options],
) -> list[dict[str, Any]]: ...


def walk_many(
    controllers: Controller | Iterable[Controller],
    terrains: Terrain | Iterable[Terrain],
    *,
    engine: str | Engine = "mujoco",
    steps: int | None = None,
    distance: float | None = None,
    initial: Initial | Sequence[Initial] = "gait",
    robot: Robot | None = None,
    sample_period: float | None = DEFAULT_SAMPLE_PERIOD,
    scuffing: ScuffingRule | None = None,
    disturbances: Disturbances | Sequence[Disturbances] | None = None,
    summaries: bool = False,
    workers: int | None = None,
    progress: bool = False,
) -> list[Any]:
    """Simulate many walks at once, each bitwise the same as by `walk()`.

    ```python
    terrains = [Terrain.random(seed=seed) for seed in range(1000)]
    walks = mjbiped.walk_many(controller, terrains, engine="hybrid", sample_period=None)
    print(sum(walk.fell for walk in walks))
    ```

    Walks whose controllers have compiled laws share the threads of this process; those in plain Python are walked in
    processes of their own, to which their controllers must go as pickles.

    Args:
        controllers: One for all walks, or one each.
        terrains: One for all walks, or one each; the first terrain goes with the first controller, and so on.
        engine: See `walk`.
        steps: See `walk`.
        distance: See `walk`.
        initial: One for all walks, or a sequence of one each.
        robot: See `walk`.
        sample_period: See `walk`; None (no samples) saves most of the memory.
        scuffing: See `walk`.
        disturbances: See `walk`; one for all walks, or a sequence of one each, for instance with a seed each.
        summaries: Return what `measures.summary` says of each walk, and no records: a walk then takes as much memory
            with a million steps as with a thousand.
        workers: Walks at a time; by default as many as there are cores for this process. No result depends on it.
        progress: Show a progress bar (never where the output is not a terminal).

    Returns:
        A record for each walk, in order; with `summaries` a dictionary for each.

    Raises:
        InputError: An argument is outside its domain, a controller's laws cannot be compiled, or it cannot be pickled;
            nothing has been computed then.
        GaitError: As for `walk`.
        WalksStopped: Walks were broken off by an error; all others are complete, and the error carries everything.
        WalksInterrupted: Ctrl-C; a `KeyboardInterrupt` that carries what has been walked.
    """
    terms = Terms(engine_of(engine), steps, distance, robot, sample_period, chosen(scuffing))
    workers = WORKERS.check("workers", cores() if workers is None else workers)
    plans = _plans(terms, controllers, terrains, initial, disturbances)
    with progress_bar(total=len(plans), desc="preparing", unit="walk", progress=progress) as bar:
        batch = Batch(plans, summaries, workers, bar)
        try:
            batch.run()
        except KeyboardInterrupt as stop:
            raise WalksInterrupted("walks interrupted", batch.results, batch.errors) from stop
    if batch.errors:
        raise _stopped(batch)
    return batch.results


def _plans(
    terms: Terms,
    controllers: Controller | Iterable[Controller],
    terrains: Terrain | Iterable[Terrain],
    initial: Initial | Sequence[Initial],
    disturbances: Disturbances | Sequence[Disturbances] | None,
) -> list[Plan]:
    """Check everything that can be checked without a simulation.

    Raises:
        InputError: The numbers differ, or one is not what is expected; the message says which walk's.
        GaitError: A walk has no passive gait to start on.
    """
    given = {"controllers": controllers, "terrains": terrains, "initial": initial, "disturbances": disturbances}
    each = {name: entries(value) for name, value in given.items()}
    if all(isinstance(start, Real) for start in each["initial"] or ()):
        each["initial"] = None  # one state for all
    counts = {name: len(values) for name, values in each.items() if values is not None}
    if len(set(counts.values())) > 1:
        got = ", ".join(f"{count} of {name}" for name, count in counts.items())
        raise InputError(f"expected one for all walks, or as many of each as there are walks; got {got}")
    count = next(iter(counts.values()), 1)
    terms = dataclasses.replace(terms, walks=count)
    columns: list[Any] = [(value,) * count if each[name] is None else each[name] for name, value in given.items()]
    described: dict[int, Mapping[str, Any]] = {}
    plans = []
    for index, (controller, terrain, start, disturbed) in enumerate(zip(*columns, strict=True)):
        try:
            plan = make_plan(terms, controller, terrain, start, described.get(id(controller)), disturbed)
        except (InputError, GaitError) as error:
            raise type(error)(f"walk {index} of {count} (counted from 0): {error}") from error
        described[id(controller)] = plan.description
        plans.append(plan)
    return plans


def _stopped(batch: Batch) -> WalksStopped:
    """Make the error that reports the broken walks."""
    first, count = min(batch.errors), len(batch.results)
    others = count - len(batch.errors)
    error = WalksStopped(
        f"{len(batch.errors)} of {count} walks stopped, the first of them walk {first} (counted from 0): "
        f"{batch.errors[first]}; the other {others} are complete, see `walks` and `errors` of this error",
        batch.results,
        batch.errors,
    )
    if batch.traces[first]:
        error.add_note(f"walk {first}:\n{batch.traces[first]}")
    return error
