"""Sums over many numbers that no test looks at one by one: scenes, searches, environments, gaits, walks, figures.

Tests that run with `GOLDEN=write` in their environment, and `-n0`, write their sums anew into `golden_numbers.json`. A
sum that has moved names the place to look at, and is right where the change was meant.
"""

import json
import math
import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from engines.conformance.cases import QUICK, name_of, walk_of
from golden_laws import LAWS, NARROW, answers
from golden_scenes import GROUNDS, ROBOTS, scene, windows
from golden_states import RESTLESS, WALKS, numbers_in, states
from golden_walks import Case
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text
from simulations import UNEQUAL

import mjbiped
import mjbiped.envs  # which gymnasium then knows
from mjbiped import Disturbances, Terrain
from mjbiped.control.registry import make_controller
from mjbiped.engines.plan import Terms, make_plan
from mjbiped.envs.tasks import WalkTask
from mjbiped.gaits.optimisation import evaluate, tell
from mjbiped.gaits.steps import CompassStep, Goal, KneedStep
from mjbiped.records.loads import pressure_place
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.rules.sole import servo_gains
from mjbiped.studies.reproduction import reproduce
from mjbiped.studies.robustness_walks import rough_from

FILE = Path(__file__).with_name("golden_numbers.json")
Named = dict[str, Any]
"""Numbers of any shape by name."""

_IN_SPACE: dict[str, tuple[Any, str, Terrain, int, float]] = {
    "sole": (mjbiped.Compass3D(**NARROW), "bounded-ankle", Terrain.level(), 3, 1.0),
    "knees": (mjbiped.Kneed3D(), "adaptive", Terrain.level(), 1, 0.5),
    "bumps": (mjbiped.Compass3D(), "adaptive", GROUNDS["bumps"], 2, 0.3),
    "placed feet": (mjbiped.Abducting3D(**NARROW), "bounded-ankle", GROUNDS["to the side"], 2, 0.2),
}  # robot, law, ground, steps, and a push to the left, N s


def sums(values: Any) -> list[float]:
    """Their number, and two sums of their logarithms, one of them with weights by their places."""
    flat = np.ravel(np.asarray(values, dtype=np.float64))
    flat = np.where(np.isfinite(flat), flat, 7.0)
    flat = np.sign(flat) * np.log1p(np.abs(flat))
    return [float(flat.size), float(flat.sum()), float(flat @ np.cos(np.arange(flat.size)))]


def reference(model: CompassStep) -> Named:
    """Cost, constraints and derivatives of a motion that is no optimum, and its measures."""
    goal = Goal(speed=0.5, clearance=0.03, retraction=True, torque_limit=40.0, friction=0.6)
    points, own = model.guess(0.2)
    x = np.concatenate([[0.7, 0.2], points[2:-1].ravel(), own])
    x += 0.01 * np.cos(np.arange(len(x)))
    told = tell(model, goal, x)
    cost, gradient, constraints, jacobian = evaluate(model, goal, 1e-2, x)
    measures = [each for each in told if isinstance(each, float)] + [*told.peak_torque, *told.broken.values()]
    return {"cost": [cost], "gradient": gradient, "constraints": constraints, "jacobian": jacobian, "told": measures}


def environment(name: str, periods: int = 40, **settings: Any) -> Named:
    """An episode with actions that swing."""
    made = gymnasium.make(f"mjbiped/{name}-v0", **settings)
    seen, told = made.reset(seed=5)
    assert made.action_space.shape
    flattened: Any = [gymnasium.spaces.flatten_space(space) for space in (made.action_space, made.observation_space)]
    rows, rewards, numbers = [seen], [], []
    for k in range(periods):
        seen, reward, ended, cut, told = made.step(0.2 * np.cos(k + np.arange(made.action_space.shape[0])))
        rows.append(seen)
        rewards.append([reward, ended, cut])
        numbers.append([value for _, value in sorted(told.items()) if isinstance(value, int | float)])
        if ended or cut:
            break
    flat = [np.concatenate([np.ravel(part) for part in row.values()]) if isinstance(row, dict) else row for row in rows]
    walk = made.unwrapped.walk()  # type: ignore[attr-defined]  # no method of gymnasium's
    bounds = [bound for space in flattened for bound in (*space.low, *space.high)]
    found = {"bounds": bounds, "outcome": [*map(ord, walk.outcome)], "observations": flat, "rewards": rewards}
    found |= {"info": [x for row in numbers for x in row]}
    return found | {f"walk's {name}": walk.samples[name] for name in ("time", "qpos", "torque")}


def gait(found: Any) -> Named:
    """All numbers that a gait tells, and its tables."""
    told = {name: getattr(found, name) for name in dir(found) if not name.startswith("_")}
    told |= {f"table {k}": np.array(table) for k, table in enumerate(told["tables"])}
    told["multipliers"] = abs(told.get("multipliers", np.zeros(1)))  # conjugate ones in any order
    return {name: value for name, value in sorted(told.items()) if isinstance(value, float | np.ndarray)}


def measures(case: Case) -> Named:
    """What is told of a whole walk."""
    walk = walk_of(case)
    found = {"summary": numbers_in(walk.summary()), "peaks": walk.peak_torque}
    return found if "kneed" in case.robot else {**found, "pressure": walk.pressure_times}


def of_functions() -> Named:
    """What functions of few numbers give."""
    robot, forces = mjbiped.FootedCompass(), [(20.0, 90.0), (-10.0, 70.0), (0.0, 1e-3)]
    pressed = [pressure_place(robot, torque, force, 0.3) for force in forces for torque in (3.0, -2.0)]
    rough = [rough_from(words) for words in ("waves", "waves:longest=3", "treads")]
    small = WalkTask("walk_level", robot=mjbiped.Compass(lower_length=0.2))
    cells = [*reproduce.table_2(), *reproduce.table_3("hybrid"), *reproduce.start(), *reproduce.figure_5("mujoco")]
    return {
        "section V": numbers_in([dict(cell.values) for cell in cells]),
        "pressure": pressed,
        "rough": rough,
        "servo": servo_gains(0.1, 0.7, 9.0),
        "peak": small.peak,
    }


@cache
def in_space(name: str, engine: str) -> mjbiped.Walk:
    """A walk in space that is pushed."""
    robot, law, ground, steps, push = _IN_SPACE[name]
    pushes = Disturbances(pushes=[(0.3, push), (0.5, -0.4 * push)], push_direction=math.pi / 2)
    asked: dict[str, Any] = {"engine": engine, "steps": steps, "disturbances": pushes, "sample_period": 0.02}
    return mjbiped.walk(make_controller(law, robot, {}), ground, **asked)


def leaning_in_space() -> Named:
    """What MuJoCo's walk tells of a robot that leans, rolls and turns far on a lateral slope."""
    law = make_controller("adaptive", mjbiped.Compass3D(), {})
    terms = Terms(mjbiped.Mujoco(), 3, None, law.robot, None, ScuffingRule())
    run: Any = terms.engine.start(make_plan(terms, law, GROUNDS["to the side"], "gait"))
    run.data.qpos[:] += 0.3 * np.cos(np.arange(run.model.nq))
    run.data.qvel[:] += np.cos(1.0 + np.arange(run.model.nv))
    run._hold(run.footing, 2.0)
    judged = [run.judged(np.array([x, 2.0 * x, z]), x) for x in (0.1, 3.0) for z in np.arange(0.0, 1.5, 0.05)]
    law = make_controller("bounded-ankle", mjbiped.Compass3D(**NARROW), {})
    planned = make_plan(replace(terms, engine=mjbiped.Hybrid(), robot=law.robot), law, GROUNDS["to the side"], "gait")
    on_sole: Any = planned.terms.engine.start(planned)
    bounded = on_sole._driven(np.array([30.0, 5.0, 20.0]), on_sole.q, on_sole.dq)
    told = {"bounded": np.concatenate(bounded), "seen": run.seen(), "held": run.model.wrap_prm, "judged": judged}
    return told | {"posture": run.posture(run.q)}


def columns(name: str, engine: str) -> Named:
    """All columns of a walk in space."""
    walk = in_space(name, engine)
    return {**walk.samples, **walk.touchdowns}


def of_figure(figure: Figure) -> Named:
    """The places and ends of its axes, its lines, the colours of its maps, and the sizes and places of its words."""
    axes = [[*each.get_position().bounds, *each.get_xlim(), *each.get_ylim()] for each in figure.axes]
    lines: Any = [np.ravel(np.asarray(line.get_xydata(), dtype=float)) for line in figure.findobj(Line2D)]
    words: Any = [text for text in figure.findobj(Text) if text.get_text() and text.get_visible()]
    places = [[text.get_fontsize(), *text.get_window_extent().bounds] for text in words]
    meshes: Any = figure.findobj(QuadMesh)
    maps = [mesh.to_rgba(mesh.get_array()).ravel() for mesh in meshes]
    flat = {"lines": np.concatenate([np.zeros(1), *lines]), "maps": np.concatenate([np.zeros(1), *maps])}
    return {"axes": axes, "words": places, **flat}


CASES: Mapping[str, Callable[[], Named]] = {
    **{f"scene of {robot}": partial(scene, robot, "to the side" if "3d" in robot else "mixed") for robot in ROBOTS},
    **{f"scene on {ground}": partial(scene, "compass", ground) for ground in ("risers", "many", "down", "ridges")},
    "scene of boxes": partial(scene, "compass", "risers", "boxes"),
    **{f"scene on {ground} in space": partial(scene, "compass3d", ground) for ground in ("bumps", "risers")},
    "reference of straight legs": lambda: reference(CompassStep(mjbiped.Compass(lower_length=0.4, sole=(0.1, 0.08)))),
    "reference with knees": lambda: reference(KneedStep(replace(UNEQUAL, sole=(0.1, 0.08)))),
    "functions": of_functions,
    "windows": windows,
    "environment": partial(environment, "CompassWalk", 120),
    "environment of erring sensors": partial(environment, "CompassWalk", 60, disturbances={"angle_noise": 1e-3}),
    "environment with knees": partial(environment, "KneedWalkStairs"),
    "environment in space": partial(environment, "Compass3D"),
    "gait": lambda: gait(mjbiped.find_passive_gait(mjbiped.Compass(4.0, 3.0, 0.4, 0.45), math.radians(2.0))),
    "gait with knees": lambda: gait(mjbiped.find_kneed_gait(mjbiped.KneedBiped(), math.radians(2.5))),
    "gait of rods with knees": lambda: gait(
        mjbiped.find_kneed_gait(mjbiped.KneedBiped.halved_rods(), math.radians(5.5))
    ),
    "gait of McGeer's machine": lambda: gait(mjbiped.find_kneed_gait(mjbiped.RoundKneed(), 0.0456)),
    "roll beside a gait with knees": lambda: gait(make_controller("adaptive", ROBOTS["kneed3d"], {}).gait),
    "gait in space with knees": lambda: gait(mjbiped.find_gait_in_space(mjbiped.Kneed3D(), math.radians(3.0))),
    "gait in space": lambda: gait(
        mjbiped.find_gait_in_space(mjbiped.Compass3D(4.0, 3.0, 0.4, 0.45), math.radians(2.0))
    ),
    **{f"walk {name_of(case)}": partial(measures, case) for case in QUICK},
    **{f"{name} in space in {on}": partial(columns, name, on) for name in _IN_SPACE for on in ("hybrid", "mujoco")},
    **{f"{on} within {name}": partial(states, name, on) for name in WALKS for on in ("hybrid", "mujoco")},
    **{f"answers of {name}": partial(answers, *law) for name, law in LAWS.items()},
    "leaning in space": leaning_in_space,
    "optimised gait": lambda: gait(mjbiped.find_reference(mjbiped.Compass(), clearance=0.06)),
}

ELSEWHERE = [
    name
    for name in CASES
    if name.startswith(("walk ", "sole in", "knees in")) or (name.startswith("gait") and name.endswith("with knees"))
]
"""Cases that tests check which make these walks, and find these gaits, anyway."""


def check(case: str, told: Named | None = None) -> None:
    """The sums of a case are what they were.

    Scenes and references to rounding. Others to 1e-6, where the linear algebra of three kinds of processors moves
    them by up to 3e-8; walks with knees to 1e-3, for 2e-4, since the search for their gait ends elsewhere on each;
    walks on narrow soles and with placed feet, whose torques stand at their bounds, to 1e-3 for 3e-5 and 1e-2 for 6e-4.
    Figures to 1e-4, and the one of branches, which are continued in other steps, to 1e-2 for 2e-3.
    What engines hold in the middle of a walk, as `RESTLESS` says.

    Args:
        case: Its name.
        told: Its numbers, where `CASES` does not make them.
    """
    moved = {"scene": 1e-9, "reference": 1e-9, "walk kneed": 1e-3, "sole in": 1e-3, "placed feet": 1e-2}
    moved |= {"tests/plotting/test_figures.py::test_figures_are_legible[bif": 1e-2, "tests": 1e-4}
    moved |= {f"{on} within {name}": each for on in ("hybrid", "mujoco") for name, each in RESTLESS.items()}
    close = next((each for begin, each in moved.items() if case.startswith(begin)), 1e-6)
    told = CASES[case]() if told is None else told
    found = {name: sums(values) for name, values in told.items()}
    stored = json.loads(FILE.read_text())
    if os.environ.get("GOLDEN") == "write":
        lines = [f"{json.dumps(name)}: {json.dumps(each)}" for name, each in {**stored, case: found}.items()]
        FILE.write_text("{\n" + ",\n".join(lines) + "\n}\n")
        return
    meant = "where the change is meant, run this test with -n0 and GOLDEN=write in its environment"
    assert found.keys() == stored.get(case, {}).keys(), meant
    for name, numbers in found.items():
        wanted, words = stored[case][name], f"{name}; {meant}"
        np.testing.assert_allclose(numbers, wanted, rtol=close, atol=close, err_msg=words)
