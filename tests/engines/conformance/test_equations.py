"""Equations of motion: both engines against free rigid bodies (`free_bodies`), and what is recorded of forces and work.

MuJoCo's matrices are compared as they are. Of the hybrid engine's motion samples are taken so densely that differences
of rates are accelerations: at each, Newton's law must hold along all motions that feet and locked knees leave.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import mujoco
import numpy as np
import pytest
from engines.conformance.cases import bodies_of, dense_walk_of, parametrised
from engines.conformance.free_bodies import Array, FreeRobot
from engines.conformance.test_impacts import LOCKED
from golden_walks import ROBOTS, Case
from simulations import UNEQUAL, build_scene

import mjbiped

PERIOD = 5e-4  # s, between samples of dense walks
DENSE = [
    Case("compass", "adaptive", "breaks", "hybrid"),
    Case("compass", "adaptive", "riser", "hybrid"),
    Case("sole", "bounded-ankle", "mixed", "hybrid"),
    Case("kneed", "adaptive", "early riser", "hybrid"),
    Case("kneed", "passive", "3 down", "hybrid"),
    Case("footed", "bounded-ankle", "level", "hybrid"),
    Case("round", "passive", "2 down", "hybrid"),
    Case("round kneed", "passive", "2 down", "hybrid"),
    Case("wheel", "passive", "8 down", "hybrid"),
]
OTHERS = {
    "other compass": mjbiped.Compass(3.1, 7.3, 0.37, 0.58, 0.11, 1.62),
    "other knees": UNEQUAL,
    "other wheel": mjbiped.RimlessWheel(mass=3.0, inertia=0.7, length=0.4, spokes=6),
}


@pytest.mark.parametrize("name", [*ROBOTS, *OTHERS])
def test_mujocos_bodies(name: str) -> None:
    """Mass matrix, Coriolis and gravity forces, and energy, in random states; to rounding of a few dozen sums.

    A hip is not without inertia there either: 2e-9 kg m^2.
    """
    robot = (ROBOTS | OTHERS)[name]
    model = build_scene(robot, mjbiped.Terrain.level(), timestep=1e-4, reach=2.0).model
    bodies = FreeRobot(robot, float(model.body("hip").mass[0]))  # a massless one is not quite massless there
    data, draw = mujoco.MjData(model), np.random.default_rng(3)
    order = [int(model.joint(place).qposadr[0]) for place in robot.places]
    M = np.zeros((model.nv, model.nv))
    for _ in range(10):
        data.qpos[:], data.qvel[:] = draw.uniform(-1.2, 1.2, model.nq), draw.uniform(-6.0, 6.0, model.nv)
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, M)
        mujoco.mj_energyPos(model, data)
        mujoco.mj_energyVel(model, data)
        qpos, v = data.qpos[order], data.qvel[order]
        scale = float(np.abs(M).max())
        np.testing.assert_allclose(M[np.ix_(order, order)], bodies.mass_matrix(qpos), rtol=0, atol=1e-9 * scale)
        np.testing.assert_allclose(data.qfrc_bias[order], bodies.bias(qpos, v), rtol=0, atol=1e-12 * scale)
        assert data.energy.sum() == pytest.approx(bodies.energy(qpos, v), abs=1e-8 * scale)


class Instant(NamedTuple):
    """A moment of a dense walk: its sample, the posture's rates and accelerations, and the force on the robot, N."""

    sample: int
    slope: float
    v: Array
    a: Array
    force: complex


def differentiated(values: Any, at: int) -> Any:
    """Rate of change at a sample, of fourth order."""
    before, after = values[at - 1] - values[at + 1], values[at + 2] - values[at - 2]
    return (-8.0 * before - after) / (12.0 * PERIOD)


def instants(case: Case, step: int, every: int) -> Iterator[Instant]:
    """Moments of a step away from its impacts, from which what is held is the same for two samples to either side."""
    walk, bodies = dense_walk_of(case), bodies_of(case.robot)
    samples, times = walk.samples, np.append(0.0, walk.touchdowns["time"])
    inside = (samples["time"] > times[step] + 1e-9) & (samples["time"] < times[step + 1] - 1e-9)
    first, last = np.flatnonzero(inside)[[0, -1]]
    locked = samples.get("locked", samples["stance"])
    columns = [samples[name][first : last + 1] for name in ("qpos", "stance", "dq", "slope")]
    rates = [bodies.rates(*row) for row in zip(*columns, strict=True)]
    momenta = [bodies.momentum(samples["qpos"][first + k], v) for k, v in enumerate(rates)]
    for at in range(first + 2, last - 1, every):
        if len({*locked[at - 2 : at + 3]}) == 1:
            here = at - first
            force = differentiated(momenta, here) + 1j * walk.robot.weight
            yield Instant(at, float(samples["slope"][at]), rates[here], differentiated(rates, here), force)


@parametrised(DENSE)
def test_newtons_law(case: Case) -> None:
    walk, bodies = dense_walk_of(case), bodies_of(case.robot)
    samples, checked = walk.samples, 0
    for step in range(walk.steps):
        if walk.touchdowns["strikes"][step]:
            continue  # a face pushes as well
        for at, slope, v, a, _ in instants(case, step, every=50):
            qpos, n = samples["qpos"][at], len(walk.robot.angles)
            columns = LOCKED if n == 3 and samples["locked"][at] else np.eye(n)
            left = bodies.motions(qpos, int(samples["stance"][at]), columns, slope)
            turning = np.concatenate([columns[:1], np.diff(columns, axis=0)])  # of the joints
            found = left.T @ (bodies.mass_matrix(qpos) @ a + bodies.bias(qpos, v))
            # errors of 1e-8 in rates over samples 0.5 ms apart, times 10 kg m^2
            np.testing.assert_allclose(found, turning.T @ samples["torque"][at], rtol=0, atol=5e-4)
            checked += 1
    assert checked > 50


@parametrised(
    [case for case in DENSE if case.robot in ("compass", "sole", "footed", "round") and case.ground != "riser"]
)
def test_what_is_kept_of_a_step_is_what_its_samples_say(case: Case) -> None:
    """Works, peaks, least normal force, friction and the centre of pressure."""
    walk = dense_walk_of(case)
    samples, touched = walk.samples, walk.touchdowns
    works: dict[str, Any] = {"absolute": np.abs, "net": np.asarray, "positive": lambda power: np.maximum(power, 0.0)}
    for step in range(walk.steps):
        found = list(instants(case, step, every=1))
        at = [each.sample for each in found]
        along, normal = np.array([each.force * np.exp(1j * each.slope) for each in found]).view(float).reshape(-1, 2).T
        time, torque, dq = (samples[name][at] for name in ("time", "torque", "dq"))
        power = torque * np.concatenate([dq[:, :1], np.diff(dq, axis=1)], axis=1)
        for kind, of in works.items():
            done = touched[f"work_{kind}"][step] - (touched[f"work_{kind}"][step - 1] if step else 0.0)
            # the samples miss up to 3 ms of the step
            missed = 3.1e-3 * float(np.abs(power).sum(axis=1).max()) + 1e-9
            assert done == pytest.approx(np.trapezoid(of(power), time, axis=0).sum(), abs=missed), kind
        # the engine looks at its nodes, some 20 in a step: parabolas between them miss their tops a little
        assert touched["normal_force"][step] == pytest.approx(normal.min(), abs=0.02 * walk.robot.weight)
        if (
            step == 0 or not bodies_of(case.robot).radius
        ):  # the impulse that began a step may ask for more than the step
            assert touched["friction"][step] == pytest.approx(np.abs(along / normal).max(), rel=0.02, abs=1e-3)
        if case.robot in ("compass", "sole"):
            place = -torque[:, 0] / normal
            assert touched["pressure_ahead"][step] == pytest.approx(place.max(), abs=1e-3)
            assert touched["pressure_behind"][step] == pytest.approx(-place.min(), abs=1e-3)
        assert touched["slip"][step] == touched["penetration"][step] == 0.0
    peaks = np.abs(samples["torque"]).max(axis=0)
    assert walk.peak_torque == pytest.approx(peaks, rel=1e-4)
