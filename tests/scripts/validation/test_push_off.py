"""The work of a push-off against the closed form for massless legs, and against angular momentum."""

import math

import pytest

from scripts.validation.push_off import LIGHT_LEGS, TABLE_ONE, closed_form, pushed, ratio


@pytest.mark.parametrize("half", [0.05, 0.2, 0.4])
def test_massless_legs_need_a_quarter_of_the_work_for_short_steps(half: float) -> None:
    # legs of 1e-9 of the hip's mass
    assert ratio(LIGHT_LEGS, half) == pytest.approx(closed_form(half), abs=1e-8)


def test_without_a_push_off_the_strike_is_the_robots_own() -> None:
    q, dq = [0.2, -0.2], [1.1, 1.1]
    work, energy = pushed(TABLE_ONE, 0.2, 1.1, 0.0)
    after = TABLE_ONE.rates_after_touchdown(q, dq)
    assert work == 0.0
    assert energy == pytest.approx(TABLE_ONE.kinetic_energy(q[::-1], after), rel=1e-13)


def test_an_impulse_that_turns_the_hip_along_its_new_arc_leaves_the_strike_nothing() -> None:
    """Massless legs: M v tan(2 alpha) along the trailing leg turns the velocity by the angle between the legs."""
    half, mass, speed = 0.2, LIGHT_LEGS.hip_mass, LIGHT_LEGS.leg_length
    work, energy = pushed(
        LIGHT_LEGS, half, 1.0, 2.0 * mass * speed * math.sin(half) * math.cos(half) / math.cos(2 * half)
    )
    # tan(2 alpha) M v turns the velocity by the whole angle 2 alpha between the legs: along the new arc
    whole = 0.5 * mass * (speed / math.cos(2 * half)) ** 2
    assert energy == pytest.approx(whole, rel=1e-8)
    assert work == pytest.approx(whole - 0.5 * mass * speed**2, rel=1e-8)
