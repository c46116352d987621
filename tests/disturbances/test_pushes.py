"""Pushes at the hip, in both engines."""

import math
from typing import Any

import numpy as np
import pytest
from scipy import stats
from simulations import make_simulation

import mjbiped
from controllers import Controller, PassiveController
from mjbiped import Disturbances, Walk

ENGINES = ("mujoco", "hybrid")
ROBOT = mjbiped.Compass()
GROUND = mjbiped.Terrain.incline(2.0)


def pushed(engine: Any, disturbances: Disturbances | None, controller: Controller | None = None, **given: Any) -> Walk:
    controller = controller or PassiveController()
    given = {"steps": 1, "sample_period": 1e-3, **given}
    return mjbiped.walk(controller, GROUND, engine=engine, disturbances=disturbances, **given)


def state_at(walk: Walk, time: float) -> tuple[Any, Any, float]:
    """Angles, rates and the hip's place in the sample at a time."""
    index = int(np.argmin(np.abs(walk.samples["time"] - time)))
    assert math.isclose(walk.samples["time"][index], time, abs_tol=1e-9)
    return walk.samples["q"][index], walk.samples["dq"][index], float(walk.samples["qpos"][index, 0])


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("impulse", [0.05, -0.05])
def test_a_short_push_is_an_impulse_through_the_mass_matrix(engine: str, impulse: float) -> None:
    """Of the change of rates, a push of 1 ms differs from M^-1 J' P by what the motion goes on in it, some 1 %."""
    start, duration = 0.2, 1e-3
    given = Disturbances(pushes=((start, impulse),), push_duration=duration)
    q, before, _ = state_at(pushed(engine, None), start)
    # by the unpushed walk's rates at the end of the push; MuJoCo's rates of now follow a force that ends one step later
    (_, free, _), (_, after, _) = (state_at(pushed(engine, each), start + 3e-3) for each in (None, given))
    lever = np.array([ROBOT.leg_length * math.cos(q[0] + math.radians(2.0)), 0.0])
    expected = np.linalg.solve(ROBOT.mass_matrix(q), lever * impulse)
    np.testing.assert_allclose(after - free, expected, rtol=0.02)
    assert np.isfinite(before).all()


@pytest.mark.parametrize(("engine", "tolerance"), [("mujoco", 1e-3), ("hybrid", 1e-7)])
def test_a_push_does_the_work_of_its_force(engine: str, tolerance: float) -> None:
    """Without motors the robot's energy changes by force times the hip's way: to second order in MuJoCo."""
    start, duration, impulse = 0.2, 0.1, 2.0
    walk = pushed(engine, Disturbances(pushes=((start, impulse),), push_duration=duration))
    # no other force works before and after; MuJoCo's rates of now follow a force that ends one step later
    (q, dq, _), (q_after, dq_after, _) = (state_at(walk, time) for time in (start - 2e-3, start + duration + 2e-3))
    (_, _, x), (_, _, x_after) = (state_at(walk, time) for time in (start, start + duration))
    slope = math.radians(2.0)
    gained = ROBOT.energy(q_after, dq_after, slope) - ROBOT.energy(q, dq, slope)
    assert math.isclose(gained, impulse / duration * (x_after - x), rel_tol=tolerance)


@pytest.mark.parametrize("lands", [True, False])
def test_mujoco_gives_a_pushs_whole_impulse(lands: bool, gait: mjbiped.Gait) -> None:
    """Also where it lasts no whole number of steps, and over a touchdown, where steps have other lengths."""
    start = gait.start.tolist()
    pushes = Disturbances(pushes=((0.1, 0.1), (0.7403, -0.5)), push_duration=0.0507)
    begin: Any = {"robot": ROBOT, "q": start[:2], "dq": start[2:], "steps": 2, "disturbances": pushes}
    timestep = 1e-3 if lands else 1e-4
    simulation = make_simulation(PassiveController(), GROUND, lands=lands, timestep=timestep, **begin)
    given, forces = 0.0, set()
    while simulation.data.time < 1.0:
        simulation.advance(1)
        force = simulation.data.qfrc_applied[0]
        given += force * simulation.state.effective_step
        forces.add(round(force, 6))
    assert simulation.state.count == 1
    assert simulation.state.pushes == 2
    assert math.isclose(given, 0.1 - 0.5, rel_tol=1e-9)
    assert {round(0.1 / 0.0507, 6), round(-0.5 / 0.0507, 6), 0.0} <= forces


def test_random_pushes_come_by_chance() -> None:
    given = Disturbances(push_impulse=2.0, push_interval=0.5, push_duration=0.1, seed=4)
    times, impulses = np.array(given.pushes_until(2000.0)).T
    gaps = np.diff(times, prepend=-0.1) - 0.1
    assert stats.kstest(gaps, "expon", args=(0.0, 0.5)).pvalue > 1e-4
    assert set(impulses) == {2.0, -2.0}
    # signs are fair: five deviations of a coin
    assert abs(impulses.sum()) < 2.0 * 5.0 * math.sqrt(len(impulses))
    assert given.pushes_until(2000.0) != Disturbances(push_impulse=2.0, push_interval=0.5, seed=5).pushes_until(2000.0)
    assert Disturbances().pushes_until(1e9) == ()


@pytest.mark.parametrize("engine", ENGINES)
def test_random_pushes_are_those_that_are_told(engine: str, controller: Controller) -> None:
    """A walk with the same pushes at given times is the same."""
    chance = Disturbances(push_impulse=1.0, push_interval=0.7, seed=3)
    told = Disturbances(pushes=chance.pushes_until(10.0))
    assert len(told.pushes) > 5
    first, second = (pushed(engine, each, controller, steps=6) for each in (chance, told))
    np.testing.assert_array_equal(first.samples["q"], second.samples["q"])


def test_the_grounds_force_knows_of_a_push() -> None:
    """Forward on a leg that leans forward, it takes load off the foot: 40 N sin 0.19 cos 0.19 is 7 N, and speeds it up.

    MuJoCo's force is its contacts', averaged over 5 ms and more; the hybrid engine's follows from the motion.
    """
    given = Disturbances(pushes=((0.6, 4.0),), push_duration=0.1)
    free = pushed("hybrid", None).touchdowns["normal_force"][0]
    tables = [pushed(engine, given).touchdowns for engine in ENGINES]
    loads, frictions = ([float(table[name][0]) for table in tables] for name in ("normal_force", "friction"))
    assert max(loads) < free - 5.0
    assert math.isclose(*loads, abs_tol=0.1 * (free - loads[1]))
    assert math.isclose(*frictions, rel_tol=0.05)
