"""Sums over many numbers that no test looks at one by one: scenes, searches for references, environments, gaits.

`python tests/golden_numbers.py` writes them anew into `golden_numbers.json`. A sum that has moved names the place to
look at, and is right where the change was meant.
"""

import json
import math
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from engines.conformance.cases import QUICK, name_of, walk_of
from golden_walks import Case

import mjbiped
import mjbiped.envs  # which gymnasium then knows
from mjbiped import Terrain
from mjbiped.engines.mujoco.ground import Ground
from mjbiped.engines.mujoco.scene import scene_spec
from mjbiped.engines.mujoco.scenery import add_section
from mjbiped.engines.mujoco.surface import add_surface
from mjbiped.gaits.optimisation import evaluate, tell
from mjbiped.gaits.steps import CompassStep, Goal, KneedStep
from mjbiped.robots.robot import Robot

FILE = Path(__file__).with_name("golden_numbers.json")
Sums = dict[str, list[float]]

ROBOTS: dict[str, Robot] = {
    robot.kind: robot
    for robot in (
        mjbiped.Compass(), mjbiped.FootedCompass(), mjbiped.KneedBiped(sole=(0.1, 0.05)), mjbiped.RoundCompass(),
        mjbiped.RoundKneed(), mjbiped.RimlessWheel(), mjbiped.Compass3D(sole=(0.1, 0.1), sole_width=0.08),
        mjbiped.Abducting3D(), mjbiped.Kneed3D(),
    )
}  # fmt: skip
STEEP = Terrain.from_segments([(0.6, -6.0), (5.0, 3.0, 0.05), (2.0, 4.0, -0.1)])
GROUNDS = {
    "mixed": Terrain.mixed(), "risers": STEEP, "bumps": Terrain.preset("bumps", rms=0.01, seed=3),
    "to the side": Terrain.preset("incline", slope_deg=2, lateral_deg=3), "many": Terrain.random(seed=3),
}  # fmt: skip
_PARTS = ("geoms", "meshes", "hfields", "bodies", "joints", "sites", "pairs", "tendons", "actuators", "sensors")


def sums(values: Any) -> list[float]:
    """Their number, and two sums of their logarithms, one of them with weights by their places."""
    flat = np.ravel(np.asarray(values, dtype=np.float64))
    flat = np.where(np.isfinite(flat), flat, 7.0)
    flat = np.sign(flat) * np.log1p(np.abs(flat))
    return [float(flat.size), float(flat.sum()), float(flat @ np.cos(np.arange(flat.size)))]


def spec_sums(spec: Any) -> Sums:
    """Of all floating-point numbers of a scene that is not compiled yet, by the kind of its parts."""
    return {part: sums([number for each in getattr(spec, part) for number in _numbers_of(each)]) for part in _PARTS}


def _numbers_of(part: Any) -> Iterator[float]:
    for name in sorted(name for name in dir(part) if not name.startswith("_")):
        value = getattr(part, name)
        if isinstance(value, float | np.ndarray) or type(value).__name__ in ("MjDoubleVec", "MjFloatVec"):
            yield from np.ravel(np.asarray(value, dtype=np.float64)).tolist()


def scene(robot: str, ground: str, kind: str = "auto") -> Sums:
    """A robot's scene, and what is seen of the ground."""
    biped, terrain = ROBOTS[robot], GROUNDS[ground]
    layout = Ground(terrain, reach=6.0, kind=kind, half_width=2.0)
    pieces = layout.window(1.0, 4.0 * biped.leg_length, biped.leg_length)
    spec = scene_spec(biped, layout, pieces, timestep=1e-4)
    if "hip_y" in biped.places:
        ends = add_surface(spec, layout, pieces, biped.leg_length, 1.0)
        return {**spec_sums(spec), "sight": sums(ends)}
    add_section(spec, layout, pieces, biped.leg_length)
    return spec_sums(spec)


def reference(model: CompassStep) -> Sums:
    """Cost, constraints and derivatives of a motion that is no optimum, and its measures."""
    goal = Goal(speed=0.5, clearance=0.03, retraction=True, torque_limit=40.0, friction=0.6)
    points, own = model.guess(0.2)
    x = np.concatenate([[0.7, 0.2], points[2:-1].ravel(), own])
    x += 0.01 * np.cos(np.arange(len(x)))
    told = tell(model, goal, x)
    cost, gradient, constraints, jacobian = evaluate(model, goal, 1e-2, x)
    measures = [each for each in told if isinstance(each, float)] + [*told.peak_torque, *told.broken.values()]
    found = {"cost": [cost], "gradient": gradient, "constraints": constraints, "jacobian": jacobian, "told": measures}
    return {name: sums(values) for name, values in found.items()}


def environment(name: str, **settings: Any) -> Sums:
    """An episode with actions that swing."""
    made = gymnasium.make(f"mjbiped/{name}-v0", **settings)
    seen, told = made.reset(seed=5)
    assert made.action_space.shape
    rows, rewards, numbers = [seen], [], []
    for k in range(40):
        seen, reward, ended, cut, told = made.step(0.2 * np.cos(k + np.arange(made.action_space.shape[0])))
        rows.append(seen)
        rewards.append([reward, ended, cut])
        numbers.append([value for _, value in sorted(told.items()) if isinstance(value, int | float)])
        if ended or cut:
            break
    flat = [np.concatenate([np.ravel(part) for part in row.values()]) if isinstance(row, dict) else row for row in rows]
    walk = made.unwrapped.walk()  # type: ignore[attr-defined]  # no method of gymnasium's
    found = {"observations": flat, "rewards": rewards, "info": [x for row in numbers for x in row]}
    found |= {f"walk's {name}": walk.samples[name] for name in ("time", "qpos", "torque")}
    return {name: sums(values) for name, values in found.items()}


def gait(found: Any) -> Sums:
    """All numbers that a gait tells, and its tables."""
    told = {name: getattr(found, name) for name in dir(found) if not name.startswith("_")}
    told |= {f"table {k}": np.array(table) for k, table in enumerate(told["tables"])}
    told["multipliers"] = abs(told.get("multipliers", np.zeros(1)))  # conjugate ones in any order
    return {name: sums(value) for name, value in sorted(told.items()) if isinstance(value, float | np.ndarray)}


def measures(case: Case) -> Sums:
    """What is told of a whole walk."""
    walk = walk_of(case)
    told = json.loads(json.dumps(dict(walk.summary()), default=str))
    flat = [each for value in told.values() for each in (value.values() if isinstance(value, dict) else [value])]
    numbers = [float(each) for each in flat if isinstance(each, int | float)]
    found = {"summary": sums(numbers), "peaks": sums(walk.peak_torque)}
    return found if "kneed" in case.robot else {**found, "pressure": sums(walk.pressure_times)}


CASES: Mapping[str, Callable[[], Sums]] = {
    **{f"scene of {robot}": partial(scene, robot, "to the side" if "3d" in robot else "mixed") for robot in ROBOTS},
    **{f"scene on {ground}": partial(scene, "compass", ground) for ground in ("risers", "many")},
    "scene on bumps": partial(scene, "compass3d", "bumps"),
    "reference of straight legs": lambda: reference(CompassStep(mjbiped.Compass(sole=(0.1, 0.08)))),
    "reference with knees": lambda: reference(KneedStep(mjbiped.KneedBiped(sole=(0.1, 0.08)))),
    "environment": partial(environment, "CompassWalk"),
    "environment with knees": partial(environment, "KneedWalkStairs"),
    "environment in space": partial(environment, "Compass3D"),
    "gait": lambda: gait(mjbiped.find_passive_gait(mjbiped.Compass(), math.radians(2.0))),
    "gait with knees": lambda: gait(mjbiped.find_kneed_gait(mjbiped.KneedBiped(), math.radians(2.5))),
    "gait of rods with knees": lambda: gait(
        mjbiped.find_kneed_gait(mjbiped.KneedBiped.halved_rods(), math.radians(5.5))
    ),
    "gait in space with knees": lambda: gait(mjbiped.find_gait_in_space(mjbiped.Kneed3D(), math.radians(3.0))),
    "gait in space": lambda: gait(mjbiped.find_gait_in_space(mjbiped.Compass3D(), math.radians(2.0))),
    **{f"walk {name_of(case)}": partial(measures, case) for case in QUICK},
    "optimised gait": lambda: gait(mjbiped.find_reference(mjbiped.Compass(), clearance=0.06)),
}

ELSEWHERE = [
    name for name in CASES if name.startswith("walk ") or (name.startswith("gait") and name.endswith("with knees"))
]
"""Cases that tests check which make these walks, and find these gaits, anyway."""


def check(case: str) -> None:
    """The sums of a case are what they were.

    Scenes and references to rounding. Others to 1e-6, where the linear algebra of three kinds of processors moves
    them by up to 3e-8; walks with knees to 1e-3, for 2e-4, since the search for their gait ends elsewhere on each.
    """
    close = 1e-9 if case.startswith(("scene", "reference")) else 1e-3 if case.startswith("walk kneed") else 1e-6
    found = CASES[case]()
    wanted = json.loads(FILE.read_text())[case]
    assert found.keys() == wanted.keys()
    for name, numbers in found.items():
        np.testing.assert_allclose(numbers, wanted[name], rtol=close, atol=close, err_msg=name)


if __name__ == "__main__":
    FILE.write_text(json.dumps({name: case() for name, case in CASES.items()}, indent=1) + "\n")
