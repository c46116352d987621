"""The torque that holds the stance knee, against Lagrange's multiplier of the lock."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from simulations import UNEQUAL

import mjbiped
from mjbiped.dynamics.modes import bent_leg
from mjbiped.errors import InputError
from mjbiped.robots.kneed import KneedBiped, stance_knee_torque

ROBOTS = [
    KneedBiped(),
    KneedBiped.halved_rods(),
    UNEQUAL,
]

triples = st.tuples(*[st.floats(-1.2, 1.2)] * 3)
fast = st.tuples(*[st.floats(-5, 5)] * 3)
strong = st.tuples(*[st.floats(-60, 60)] * 3)


@given(st.sampled_from(ROBOTS), triples, fast, strong, st.floats(-0.3, 0.3), st.booleans(), st.floats(0.0, 1.2))
@settings(deadline=None, derandomize=True)
def test_it_is_the_multiplier_of_the_lock(
    robot: KneedBiped,
    q: tuple[float, float, float],
    dq: tuple[float, float, float],
    torque: tuple[float, float, float],
    slope: float,
    locked: bool,
    flexion: float,
) -> None:
    """The chain of four segments, its motors between them, with a row for each joint that keeps its angle."""
    rates = (dq[0], dq[1], dq[1]) if locked else dq
    found = stance_knee_torque(robot, q, rates, torque, slope, locked=locked, stance_flexion=flexion)
    _, lean = bent_leg(robot.thigh_length, robot.shank_length, flexion)
    angles = np.array([q[0] + lean, q[0] + lean - flexion, q[1], q[2]])
    turning = np.array([rates[0], *rates])
    ankle, hip, knee = torque
    forces = np.array([ankle, 0.0, 0.0, 0.0]) + hip * np.array([0, -1, 1, 0]) + knee * np.array([0, 0, -1, 1])
    forces -= robot.coriolis_matrix(angles, turning) @ turning + robot.gravity_vector(angles, slope)
    held = np.array([[-1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]])[: 2 if locked else 1]  # thigh on, shank back
    none = np.zeros((len(held), len(held)))
    whole = np.block([[robot.mass_matrix(angles), -held.T], [held, none]])
    multipliers = np.linalg.solve(whole, np.concatenate([forces, np.zeros(len(held))]))[4:]
    # rounding of some dozens of operations, of the largest force, through a condition number of up to 1e3
    assert found == pytest.approx(multipliers[0], abs=1e-9 * (1.0 + np.abs(forces).max()))


def test_statics_by_hand() -> None:
    """A leg without a body: bent, it carries the hip's weight at the knee's distance from the line of the leg."""
    robot = KneedBiped(1e-3, 1e-3, 10.0, thigh_inertia=1e3, shank_inertia=1e3)  # so inert that nothing moves
    flexion = 0.5
    found = stance_knee_torque(robot, (0, 0, 0), (0, 0, 0), (0, 0, 0), 0.0, locked=False, stance_flexion=flexion)
    reach, _ = bent_leg(0.5, 0.5, flexion)
    aside = math.sqrt(0.25 - reach**2 / 4)
    # the weights of the links are left out, 4e-4 of the hip's; and what is inert is not at rest, 1e-3
    assert found == pytest.approx(10.0 * 9.81 * aside, rel=3e-3)
    bent_on = stance_knee_torque(robot, (0, 0, 0), (0, 0, 0), (0, 0, 0), 0.0, locked=False)
    assert abs(bent_on) < 1e-9  # upright and straight it carries nothing


def test_many_instants_at_once_are_each_by_itself() -> None:
    random = np.random.default_rng(3)
    q, dq, torque = random.uniform(-1, 1, (3, 2, 5, 3))
    locked = random.uniform(size=(2, 5)) > 0.5
    found = stance_knee_torque(mjbiped.KneedBiped(), q, dq, torque, 0.1, locked=locked, stance_flexion=0.2)
    assert found.shape == (2, 5)
    for place in np.ndindex(2, 5):
        alone = stance_knee_torque(
            mjbiped.KneedBiped(), q[place], dq[place], torque[place], 0.1, locked=locked[place], stance_flexion=0.2
        )
        assert alone == found[place]


def test_bad_input_is_refused_and_a_torque_that_is_no_number_is_not() -> None:
    robot, rest = mjbiped.KneedBiped(), (0.0, 0.0, 0.0)
    with pytest.raises(InputError, match="q: nan in it"):
        stance_knee_torque(robot, (math.nan, 0.0, 0.0), rest, rest, 0.0, locked=False)
    with pytest.raises(InputError, match=r"dq: expected shape \(\.\.\., 3\), got \(2,\)"):
        stance_knee_torque(robot, rest, (0.0, 0.0), rest, 0.0, locked=False)
    assert np.isnan(stance_knee_torque(robot, rest, rest, (math.nan, 0.0, 0.0), 0.0, locked=False))
