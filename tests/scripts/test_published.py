"""What others have published, against this laboratory; where they are wrong, the calculation that gives their digits.

Tolerances are those of the published digits and of ours, as `scripts.validation` tells them.
"""

import math

import numpy as np
import pytest
from documentation import table
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import root

import mjbiped
from mjbiped.gaits.passive import find_passive_gait
from mjbiped.limit_cycles.periodic import first_gait
from mjbiped.robots.compass import Array, Compass
from scripts.validation import (
    compass_gait,
    drake_invariants,
    kneed_walker,
    rimless_wheel,
    rolling_disc,
    simplest_walker,
)
from scripts.validation.page import SOURCES, minus
from scripts.validation.published import DRAKE, GARCIA, GARCIA_SLOPE, GOSWAMI, GOSWAMI_ROBOT, HSU_CHEN, HSU_CHEN_ROBOT
from scripts.validation.rimless_wheel import LIGHT_LEGS, closed_form, pushed, ratio

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


def heelstrike_map(slope: float, theta: float, rate: float) -> tuple[Array, float]:
    """Garcia, Chatterjee, Ruina, Coleman 1998: one step of the simplest walker, (theta, its rate) and the period.

    Their equations (1) and (2), phi the angle between the legs, with heelstrike at phi = 2 theta once the swing leg
    has passed, and their transition (3); nothing of `mjbiped` is used.
    """

    def motion(_: float, y: Array) -> list[float]:
        theta, rate, phi, phi_rate = y.tolist()
        first = math.sin(theta - slope)
        second = first + (rate * rate - math.cos(theta - slope)) * math.sin(phi)
        return [rate, first, phi_rate, second]

    def heelstrike(t: float, y: Array) -> float:
        return float(y[2] - 2 * y[0]) if y[0] < -0.05 else -1.0

    heelstrike.terminal = True  # type: ignore[attr-defined]
    start = [theta, rate, 2 * theta, (1 - math.cos(2 * theta)) * rate]
    solution = solve_ivp(motion, (0, 10), start, "DOP853", events=heelstrike, rtol=1e-12, atol=1e-13, max_step=0.2)
    assert solution.t_events is not None
    assert solution.y_events is not None
    before = solution.y_events[0][0]
    return np.array([-before[0], math.cos(2 * before[0]) * before[1]]), float(solution.t_events[0][0])


def simplest_gait(slope: float, guess: tuple[float, float]) -> tuple[Array, float, NDArray[np.complex128]]:
    """Fixed point, period and multipliers of the simplest walker, from its own equations."""

    def mismatch(x: Array) -> Array:
        difference: Array = heelstrike_map(slope, float(x[0]), float(x[1]))[0] - x
        return difference

    solution = root(mismatch, guess, tol=1e-12)
    h = 3e-6
    columns = [
        (heelstrike_map(slope, *(solution.x + h * e))[0] - heelstrike_map(slope, *(solution.x - h * e))[0]) / (2 * h)
        for e in np.eye(2)
    ]
    multipliers = np.linalg.eigvals(np.column_stack(columns)).astype(np.complex128)
    return solution.x, heelstrike_map(slope, *solution.x)[1], multipliers


@pytest.mark.parametrize("name", ["long", "short"])
def test_garcias_own_equations_give_the_same_gaits(name: str) -> None:
    """Integrated to 1e-12; the multipliers by central differences, good to 1e-6 as ours are."""
    guess = (GARCIA[f"{name} angle"].value.real, GARCIA[f"{name} rate"].value.real)
    point, period, multipliers = simplest_gait(GARCIA_SLOPE, guess)
    gait = simplest_walker.gait(name)
    np.testing.assert_allclose(gait.states[0], simplest_walker.after_heelstrike(*point.tolist()), rtol=0, atol=5e-12)
    assert gait.periods[0] == pytest.approx(period, abs=1e-11)
    np.testing.assert_allclose(np.sort_complex(multipliers), np.sort_complex(gait.multipliers[:2]), rtol=0, atol=2e-6)


def test_garcias_multipliers_are_one_sided_quotients() -> None:
    """Of width 1e-5 at the printed fixed points: eight digits of the pair, and all that are printed of the others."""
    pair = simplest_walker.upper(simplest_walker.one_sided_multipliers("long"))
    assert abs(pair - GARCIA["long pair"].value) < 2e-8  # the return map's error of 1e-12 over 1e-5 is a tenth of that
    for name, found in zip(("first", "second"), simplest_walker.one_sided_multipliers("short"), strict=True):
        assert abs(found - GARCIA[f"short {name}"].value) < GARCIA[f"short {name}"].tolerance


def test_garcias_series_contradict_themselves_for_long_gaits_alone() -> None:
    """α and c₁ of each kind of gait give its Θ₁ by the rimless wheel: ours for both, the published one for short gaits.

    Half a unit of the last digit of α and c₁ makes 1e-6 of Θ₁.
    """
    for name, wrong in (("long", True), ("short", False)):
        demanded = simplest_walker.angle_by_the_wheel(
            *(GARCIA[f"{name} {term}"].value.real for term in ("alpha", "c1"))
        )
        assert demanded == pytest.approx(simplest_walker.series(name).angle[1], abs=1e-6)
        assert (abs(demanded - GARCIA[f"{name} Theta1"].value) > 1e-6) == wrong


def simplest(mass_ratio: float, height: float) -> Compass:
    """A compass near the simplest walker: leg mass over hip mass, and height of the legs' mass above the foot."""
    return Compass(mass_ratio, 1.0, lower_length=height, upper_length=1 - height, leg_inertia=0.0, gravity=1.0)


@pytest.mark.parametrize("parameter", ["mass ratio", pytest.param("height", marks=pytest.mark.slow)])
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
def test_goswamis_gait_in_mujoco() -> None:
    """MuJoCo knows no impact map; its soft contacts leave 1e-4."""
    names = ("period", "angle", "stance rate", "swing rate")
    for name, found in zip(names, compass_gait.in_mujoco().tolist(), strict=True):
        assert found == pytest.approx(compass_gait.GOSWAMIS[name]().value.real, abs=2e-4)
        assert found == pytest.approx(GOSWAMI[name].value.real, abs=GOSWAMI[name].tolerance + 2e-4)


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


def test_euler_steps_tend_to_the_exact_gait() -> None:
    """Their error is of first order: twice the one of half the step, but for terms of second order."""
    exact = kneed_walker.gait(HSU_CHEN_ROBOT).start[[0, 3, 4]]
    whole, half = (kneed_walker.euler_gait(HSU_CHEN_ROBOT, width) for width in (1e-3, 5e-4))
    np.testing.assert_allclose((whole - exact) / (half - exact), 2.0, rtol=0, atol=0.05)


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


@pytest.mark.parametrize(
    ("engine", "drift"),
    [
        ("hybrid engine", 2e-8),  # its tolerance for an integration step is 1e-8
        ("hybrid engine, tolerance 1e-12", 2e-11),
        ("MuJoCo", 2e-4),  # the ground is soft
    ],
)
def test_energy_between_impacts(engine: str, drift: float) -> None:
    assert drake_invariants.energy_drift(drake_invariants.ENGINES[engine]) < drift


def test_a_rimless_wheel_rolls_as_its_closed_form_says() -> None:
    """In the hybrid engine, from off the fixed point; the legs' mass, of first order, is what it differs by."""
    light, heavier = (rimless_wheel.roll(ratio, mjbiped.Hybrid(tolerance=1e-10)) for ratio in (1e-12, 1e-6))
    np.testing.assert_allclose(*light, rtol=0, atol=1e-11)
    apart = np.abs(heavier[0] - heavier[1]).max()
    assert 1e-7 < apart < 1e-5


@pytest.mark.slow
def test_a_rimless_wheel_rolls_in_mujoco() -> None:
    """Its legs have a thousandth of the hip's mass, which alone makes some 1.5e-3 rad/s."""
    np.testing.assert_allclose(*rimless_wheel.roll(1e-3, mjbiped.Mujoco()), rtol=0, atol=4e-3)


@pytest.mark.parametrize("name", ["long", "short"])
def test_the_simplest_walkers_stance_leg_is_a_spoke(name: str) -> None:
    assert simplest_walker.wheel_rate(name) == pytest.approx(0.0, abs=5e-12)


@pytest.mark.parametrize("half", [0.05, 0.2, 0.4])
def test_massless_legs_need_a_quarter_of_the_work_for_short_steps(half: float) -> None:
    # legs of 1e-9 of the hip's mass
    assert ratio(LIGHT_LEGS, half) == pytest.approx(closed_form(half), abs=1e-8)


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


@pytest.mark.parametrize(("wheel", "limit"), [("uniform disc", 1 / 3), ("hoop", 1 / 4)])
def test_a_rolling_wheel_becomes_stable_at_its_published_speed(wheel: str, limit: float) -> None:
    k, whole = rolling_disc.WHEELS[wheel], rolling_disc.GRAVITY * rolling_disc.RADIUS
    for tilt, error in zip(rolling_disc.PHYSICS, (1e-7, 1e-4), strict=True):  # MuJoCo's steps of 0.1 ms leave 6e-5
        assert rolling_disc.found(tilt, k) ** 2 / whole == pytest.approx(limit, rel=error)
        assert tilt(k, 0.9 * math.sqrt(limit * whole)) > rolling_disc.NUDGE * rolling_disc.SPAN
