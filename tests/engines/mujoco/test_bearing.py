"""What the ground does to the feet: touchdowns, averages of forces, friction that lasts."""

import math

import pytest
from standing import AWAY, ROBOT, SLOPE, begun, constants, standing_at

from mjbiped.engines.mujoco import feet
from mjbiped.engines.mujoco.feet import Felt
from mjbiped.rules.termination import LIGHT_CONTACT


def test_friction_counts_that_lasts() -> None:
    """In a step of 10 µs after an impact a foot is at the limit of friction, and slides by less than a micrometre."""
    c, u = constants(), begun(standing_at(0.0, 0.1, -0.2))
    for step, ratio, expected in (
        (1e-5, 0.8, 0.0),
        (1e-3, 0.3, 0.3),
        (1e-3, 0.4, 0.4),
        (1e-3, 0.2, 0.4),
        (1e-5, 0.8, 0.4),
    ):
        u.effective_step, u.ratio = step, ratio
        feet.weigh(c, u, u.torque[0])
        assert u.friction == expected


def test_the_normal_force_is_averaged_over_stretches_that_end_in_contact() -> None:
    """Single physics steps without contact do not count; a foot that is off the ground for longer bears nothing."""
    c, u = constants(), begun(standing_at(0.0, 0.1, -0.2))
    u.effective_step, u.torque[0] = 1e-3, 4.0
    count = math.ceil(c.averaged / 1e-3 - 1e-9)
    forces = [60.0 + 2.0 * k for k in range(count - 1)]
    for force in [*forces, 0.0]:
        u.force = force
        feet.weigh(c, u, u.torque[0])
    assert u.normal_force == math.inf  # it ends out of contact: not yet
    u.force = 100.0
    feet.weigh(c, u, u.torque[0])
    average = (sum(forces) + 100.0) / (count + 1)
    assert u.normal_force == pytest.approx(average)
    assert -u.pressure[0] == u.pressure[1] == pytest.approx(4.0 / average)
    assert sum(u.pressure[2:]) == pytest.approx((count + 1) * 1e-3)
    assert u.stretch == u.impulse == u.ankle_impulse == 0.0
    u.force = 0.0
    for k in range(math.ceil(c.airborne / 1e-3 - 1e-9)):
        assert u.normal_force > 0.0, k
        feet.weigh(c, u, u.torque[0])
    assert u.normal_force == 0.0


@pytest.mark.parametrize(("share", "near"), [(0.8, False), (1.2, True)])
def test_the_ankle_of_a_foot_that_hardly_presses_asks_for_a_centre_far_away(share: float, near: bool) -> None:
    c, u = constants(), begun(standing_at(0.0, 0.1, -0.2))
    u.effective_step, u.torque[0], u.force = c.averaged, -0.1, share * LIGHT_CONTACT * c.weight
    feet.weigh(c, u, u.torque[0])
    assert (u.pressure[-1] == 0.0) == near


def test_a_step_too_short_for_an_average_tells_the_mean_of_what_there_was() -> None:
    u = begun(standing_at(0.0, 0.1, -0.2))
    assert math.isnan(feet.least_normal_force(u))
    u.impulse, u.stretch = 0.12, 2e-3
    assert feet.least_normal_force(u) == pytest.approx(60.0)
    u.normal_force = 7.0
    assert feet.least_normal_force(u) == 7.0


@pytest.mark.parametrize("enabled", [False, True])
def test_what_the_feet_feel(enabled: bool) -> None:
    """A swing foot that may collide and meets the ground makes a touchdown: that step's load is of the impact."""
    light = 0.005 * ROBOT.weight
    stance = Felt(40.0, 12.0, 40.0, 2e-6, True, False)
    used = abs(12.0 * math.cos(SLOPE) + 40.0 * math.sin(SLOPE)) / (40.0 * math.cos(SLOPE) - 12.0 * math.sin(SLOPE))
    swinging = standing_at(0.0, 0.1, -0.2)
    u = begun(swinging)
    u.enabled = float(enabled)
    feet.note_contacts(constants(), u, stance, Felt(9.0, 1.0, 9.0, 5e-6, True, True), True)
    assert (u.noted, u.face_impacts, u.force) == (float(enabled), float(enabled), 40.0)
    assert u.penetration == (5e-6 if enabled else 2e-6)
    assert u.ratio == (0.0 if enabled else pytest.approx(used))
    feet.note_contacts(constants(), u, Felt(light, light, light, 1e-6, True, False), AWAY, True)
    assert (u.noted, u.force) == (0.0, light)
    assert u.penetration == (5e-6 if enabled else 2e-6)  # the greatest stays
    u = begun(swinging)
    feet.note_contacts(constants(), u, Felt(light, light, light, 1e-6, True, False), AWAY, True)
    assert u.ratio == 0.0  # hardly a contact
    feet.note_contacts(constants(), u, AWAY, AWAY, True)
    assert u.force == 0.0
