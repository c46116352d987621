"""What others have published, against this laboratory; where they are wrong, the calculation that gives their digits.

Tolerances are those of the published digits and of ours, as `scripts.validation` tells them.
"""

import math

import numpy as np
import pytest
from documentation import table

import mjbiped
from mjbiped import Compass, find_passive_gait
from mjbiped.limit_cycles.periodic import first_gait
from scripts.validation import (
    compass_gait,
    drake_invariants,
    kneed_walker,
    rimless_wheel,
    rolling_disc,
    simplest_walker,
)
from scripts.validation.page import SOURCES, minus
from scripts.validation.published import DRAKE, GARCIA, GARCIA_SLOPE, GOSWAMI_ROBOT, HSU_CHEN, HSU_CHEN_ROBOT
from scripts.validation.rimless_wheel import LIGHT_LEGS, closed_form, ratio

SLOW = {"doubling", "lost", "first doubling", "second doubling", "third doubling", "no period"}
"""Numbers that take seconds; those of Hsu Chen's second robot do as well."""


def numbers() -> list[object]:
    return [
        pytest.param(source, name, marks=pytest.mark.slow if name in SLOW or name.startswith("second s") else ())
        for source, (_, published, _) in SOURCES.items()
        for name in published
    ]


@pytest.mark.parametrize(("source", "name"), numbers())
def test_a_published_number_is_reproduced_or_has_a_fault(source: str, name: str) -> None:
    """Within what its digits, or its source, allow; a number that is said to be wrong is not."""
    _, published, computations = SOURCES[source]
    ours, number = computations[name](), published[name]
    distance = abs(ours.value - number.value)
    if number.fault:
        assert distance > number.tolerance + ours.error
    else:
        assert distance < number.tolerance + ours.error


@pytest.mark.parametrize("source", SOURCES)
def test_every_published_number_is_computed_and_stands_on_the_page(source: str) -> None:
    _, published, computations = SOURCES[source]
    assert published.keys() == computations.keys()
    printed = [row["published"] for row in table("validation", source)]
    assert printed == [minus(number.printed.replace("+", "±")) for number in published.values()]


def test_garcias_multipliers_are_one_sided_quotients() -> None:
    """Of width 1e-5 at the printed fixed points: eight digits of the pair, and all that are printed of the others."""
    pair = simplest_walker.upper(simplest_walker.one_sided_multipliers("long"))
    assert abs(pair - GARCIA["long pair"].value) < 2e-8  # the return map's error of 1e-12 over 1e-5 is a tenth of that
    for name, found in zip(("first", "second"), simplest_walker.one_sided_multipliers("short"), strict=True):
        assert abs(found - GARCIA[f"short {name}"].value) < GARCIA[f"short {name}"].tolerance


def simplest(mass_ratio: float, height: float) -> Compass:
    """A compass near the simplest walker: leg mass over hip mass, and height of the legs' mass above the foot."""
    return Compass(mass_ratio, 1.0, lower_length=height, upper_length=1 - height, leg_inertia=0.0, gravity=1.0)


@pytest.mark.slow
@pytest.mark.parametrize("parameter", ["mass ratio", "height"])
def test_garcia_is_the_limit_of_our_model(parameter: str) -> None:
    """The difference is of first order in the legs' mass, and in its height above the feet."""
    limit = simplest_walker.long_gait()
    expected = np.array([-limit.start[0], -limit.start[2], limit.period, abs(limit.multipliers[0])])
    small, values = np.array([1e-3, 1e-4, 1e-5]), []
    for share in small.tolist():
        gait = find_passive_gait(
            simplest(*((share, 1e-9) if parameter == "mass ratio" else (1e-9, share))), GARCIA_SLOPE
        )
        values.append([-gait.start[0], -gait.start[2], gait.period, abs(gait.multipliers[0])])
    errors = np.array(values) - expected
    # first order: each error is a tenth of the one before, but for a share of second order, some hundred times `small`
    np.testing.assert_allclose(errors[2] / errors[1], 0.1, rtol=0.01)
    # the first order taken out: the other parameter's 1e-9 is left, some 1e-8, and of multipliers their error of 1e-6
    rest = simplest_walker.without_first_order(small, errors)[-1]
    assert (np.abs(rest) < [2e-8, 2e-8, 2e-8, 1e-6]).all()


@pytest.mark.slow
def test_goswamis_first_doubling_by_two_ways() -> None:
    """The gait on 4.38 degrees, beyond the published onset of 4.37, is stable by two return maps."""
    for finder in (find_passive_gait, first_gait):
        assert finder(GOSWAMI_ROBOT, math.radians(4.38)).stable
        assert not finder(GOSWAMI_ROBOT, math.radians(4.40)).stable


@pytest.mark.slow
def test_goswamis_chaos() -> None:
    """On 5.2 degrees no period up to 256 is left, and walks that begin 1e-9 apart part."""
    period, steps = compass_gait.chaos()
    assert period == 0
    assert 0 < steps < 100


@pytest.mark.parametrize("prefix", ["", pytest.param("second ", marks=pytest.mark.slow)])
def test_hsu_chens_digits_are_those_of_euler_steps(prefix: str) -> None:
    """Her walk had come that near to the fixed point; the sign of one angle is lost in the program."""
    for quantity in kneed_walker.QUANTITIES:
        ours = kneed_walker.HSU_CHENS[prefix + quantity]()
        assert ours.as_published is not None
        assert abs(ours.as_published - HSU_CHEN[prefix + quantity].value) < 1e-9


@pytest.mark.slow
def test_hsu_chens_multipliers_are_noise() -> None:
    """A fit to 25 runs tells ours from disturbances of 1e-4, and anything, signs included, from those of 1e-2."""
    ours = np.sort_complex(kneed_walker.gait(HSU_CHEN_ROBOT).multipliers)
    small, large = (
        np.array([kneed_walker.fitted_multipliers(size, seed) for seed in range(4)]) for size in (1e-4, 1e-2)
    )
    assert np.abs(small - ours).max() < 0.1  # of the Euler steps' own multipliers, which are 0.04 from ours, 0.05
    assert np.ptp(large.real, axis=0).max() > 0.5
    assert large.real.min() < HSU_CHEN["pair"].value.real < HSU_CHEN["real"].value.real < large.real.max()


@pytest.mark.parametrize("name", DRAKE)
def test_drakes_invariants(name: str) -> None:
    assert drake_invariants.INVARIANTS[name][1]() < DRAKE[name]


def test_a_rimless_wheel_rolls_as_its_closed_form_says() -> None:
    """In the hybrid engine, from off the fixed point; the legs' mass, of first order, is what it differs by."""
    light, heavier = (rimless_wheel.roll(ratio, mjbiped.Hybrid(tolerance=1e-10)) for ratio in (1e-12, 1e-6))
    np.testing.assert_allclose(*light, rtol=0, atol=1e-11)
    apart = np.abs(heavier[0] - heavier[1]).max()
    assert 1e-7 < apart < 1e-5


@pytest.mark.parametrize("name", ["long", "short"])
def test_the_simplest_walkers_stance_leg_is_a_spoke(name: str) -> None:
    assert simplest_walker.wheel_rate(name) == pytest.approx(0.0, abs=5e-12)


@pytest.mark.parametrize("half", [0.05, 0.2, 0.4])
def test_massless_legs_need_a_quarter_of_the_work_for_short_steps(half: float) -> None:
    # legs of 1e-9 of the hip's mass
    assert ratio(LIGHT_LEGS, half) == pytest.approx(closed_form(half), abs=1e-8)


@pytest.mark.parametrize(("wheel", "limit"), [("uniform disc", 1 / 3), ("hoop", 1 / 4)])
def test_a_rolling_wheel_becomes_stable_at_its_published_speed(wheel: str, limit: float) -> None:
    k, whole = rolling_disc.WHEELS[wheel], rolling_disc.GRAVITY * rolling_disc.RADIUS
    for tilt, error in zip(rolling_disc.PHYSICS, (1e-7, 1e-4), strict=True):  # MuJoCo's steps of 0.1 ms leave 6e-5
        assert rolling_disc.found(tilt, k) ** 2 / whole == pytest.approx(limit, rel=error)
        assert tilt(k, 0.9 * math.sqrt(limit * whole)) > rolling_disc.NUDGE * rolling_disc.SPAN
