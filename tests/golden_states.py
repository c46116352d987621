"""All numbers that an engine holds in the middle of a walk: its state with the memory of the law, and its constants."""

import cProfile
import ctypes
import dataclasses
import math
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from golden_walks import COMPARED, GROUNDS, ROBOTS
from simulations import UNEQUAL, Torques, hybrid_run, make_simulation

import mjbiped
from mjbiped.control.controller import Controller
from mjbiped.control.registry import make_controller
from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.engines.hybrid.gait_step import advance
from mjbiped.engines.hybrid.meeting import acceleration_bound
from mjbiped.numerics.blocks import Block
from mjbiped.robots.robot import Robot

PUSHED = Disturbances(pushes=((0.1, 1.0), (0.4, -0.7)))
LATE = Disturbances(delay=2e-3, control_period=1e-3, torque_limit=30.0, pushes=((0.2, 0.5),))
SWINGING = Torques(lambda t, _, dq: (3.0 * math.cos(9.0 * t) - 2.0 * dq[0], 3.0 * math.cos(9.0 * t + 1.0) - dq[1]))
STARTS = {
    "wheel": ((-0.3,), (1.5,)),
    **dict.fromkeys(("compass", "sole", "round"), ((-0.2, 0.2), (1.1, 0.6))),
    **dict.fromkeys(("kneed", "kneed on soles"), ((-0.2, 0.25, 0.25), (1.2, 0.3, 0.3))),
    **dict.fromkeys(("footed", "boxes"), ((-0.2, 0.2, 0.0, 0.0), (1.2, 0.6, 0.0, 0.0))),
}
ODD: dict[str, Robot] = {
    "compass": mjbiped.Compass(4.0, 3.0, 0.4, 0.45),
    "sole": mjbiped.Compass(4.0, 3.0, 0.4, 0.45, sole=(0.1, 0.08)),
    "kneed": UNEQUAL,
    "footed": mjbiped.FootedCompass(6.0, 3.0, 0.6, 0.55),
    "round": mjbiped.RoundCompass(6.0, 3.0, 0.6, 0.55),
}
"""Robots whose legs are not 1 m long, and have no other number of the default ones; for the law that swings."""

_CALM = [law for law in COMPARED if law != "kinetic-energy"]  # whose walk moves by 4e-4 with gravity's last bits
WALKS = {
    f"{robot} {law} {ground}": (robot, law, ground)
    for robot, laws, grounds in (
        ("compass", ("swinging", "adaptive", *_CALM), ("breaks", "downstairs")),
        ("sole", ("swinging", "bounded-ankle", "supervised"), ("breaks", "mixed")),
        ("kneed", ("swinging", "adaptive"), ("breaks", "early riser", "later riser")),
        ("kneed on soles", ("bounded-ankle",), ("mixed",)),
        ("footed", ("swinging",), ("breaks", "downstairs")),
        ("footed", ("supervised",), ("mixed",)),
        ("boxes", ("swinging",), ("breaks",)),
        ("round", ("swinging",), ("breaks",)),
        ("wheel", ("passive",), ("8 down",)),
    )
    for law in laws
    for ground in grounds
}


def numbers_in(told: Any) -> list[float]:
    """All numbers within blocks, tables and lists."""
    if isinstance(told, Block):
        told = vars(told)
    elif isinstance(told, ctypes.Structure):
        told = [np.array(getattr(told, name)) for name, *_ in told._fields_]
    elif dataclasses.is_dataclass(told):
        told = [getattr(told, field.name) for field in dataclasses.fields(told)]
    if isinstance(told, np.ndarray):
        return [float(x) for x in told.ravel()] if told.dtype.names is None else []
    if isinstance(told, Mapping | list | tuple):
        return [x for each in (told.values() if isinstance(told, Mapping) else told) for x in numbers_in(each)]
    return [float(told)] if isinstance(told, int | float) else []


RESTLESS = {"kneed adaptive": 1e-3, **dict.fromkeys(("kneed on", "sole bounded", "sole super", "compass limit"), 1e-4)}
"""Walks whose numbers move by up to a tenth of this with gravity's last bits; those of others move by 1e-7."""


COUNTED = (
    "torque", "_torque", "ask", "rates", "value_at", "rate_at", "ground_force", "add_row", "height_of", "segment_near",
    "swing_foot", "foot_after", "knee_after", "end_of_leg", "bin_of", "is_motion", "write_torques",
)  # fmt: skip
"""Functions whose calls tell how much an engine computes: laws, accelerations, values within steps, feet, heights."""


def counted(advance: Callable[[], object]) -> list[float]:
    """How often each of these functions is called."""
    with cProfile.Profile(builtins=False) as profile:
        advance()
    calls = Counter[str]()
    for each in profile.getstats():
        calls[getattr(each.code, "co_name", "")] += each.callcount
    return [float(calls[name]) for name in COUNTED]


def states(name: str, engine: str) -> dict[str, list[float]]:
    """The numbers at some moments of a walk, and how much was computed since the last one."""
    kind, law, ground = WALKS[name]
    robot = ODD.get(kind, ROBOTS[kind]) if law == "swinging" else ROBOTS[kind]
    controller: Controller = SWINGING if law == "swinging" else make_controller(law, robot, {})
    q, dq = (values[: len(robot.angles)] for values in STARTS[kind])
    disturbed = Disturbances() if kind == "wheel" else LATE if law == "adaptive" else PUSHED
    given: Any = {"robot": robot, "q": q, "dq": dq, "disturbances": disturbed, "compile": False}
    if engine == "mujoco":
        simulation = make_simulation(controller, GROUNDS[ground], timestep=1e-3, **given)
        found = {"constants": numbers_in(simulation.constants)}
        for moment in range(6):
            if moment % 3 == 0:  # a count takes as long as the steps themselves
                found[f"calls {moment}"] = counted(lambda: simulation.advance(150))
            else:
                simulation.advance(150)
            found[f"state {moment}"] = numbers_in(simulation.state)
        return found
    run = hybrid_run(controller, GROUNDS[ground], **given)
    w, found = run.state, {"constants": numbers_in(run.constants)}
    for moment in range(8):
        w.rows = w.samples = 0
        w.pause = w.evaluations + 150.0
        found[f"calls {moment}"] = counted(lambda: advance(run.constants, w))
        found[f"state {moment}"] = [*numbers_in(w), acceleration_bound(run.constants, w)]
    return found
