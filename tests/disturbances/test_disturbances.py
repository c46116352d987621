"""What can be asked of `Disturbances`, what is refused, random numbers by their places, friction, the command line."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats
from simulations import make_simulation

import mjbiped
from controllers import PassiveController
from mjbiped.cli.walkers import disturbances_of, model_of
from mjbiped.disturbances import chance
from mjbiped.disturbances.disturbances import UNDISTURBED, Disturbances
from mjbiped.studies.plan import plan

GROUND = mjbiped.Terrain.incline(2.0)


OWN: Any = type("Own", (mjbiped.Engine,), {"name": "own", "start": None})()


def walk(engine: Any = "hybrid", **given: Any) -> mjbiped.Walk:
    return mjbiped.walk(PassiveController(), GROUND, engine=engine, disturbances=Disturbances(**given), steps=3)


def study(**settings: Any) -> Any:
    given = {"steps": 3, "engine": "hybrid", "terrain": {"name": "level"}, "disturbances": settings}
    return plan(Path("study.toml"), given)


REFUSED: list[tuple[Any, str]] = [
    (lambda: Disturbances(angle_noise=-1.0), r"angle_noise = -1.0: must be from 0 to 1 rad"),
    (lambda: Disturbances(torque_limit=(1.0, -2.0)), "torque_limit, number 2 = -2.0"),
    (lambda: walk("hybrid", torque_limit=(1.0, 2.0, 3.0)), "one for each of ankle, hip"),
    (lambda: disturbances_of([("torque_limit", "3,x")], []), "a finite number or numbers with commas"),
    (lambda: Disturbances(pushes=[(1.0,)]), r"expected shape \(n, 2\)"),  # type: ignore[list-item]
    (lambda: Disturbances(pushes=[(2.0, 1.0), (2.01, 1.0)]), "push_duration = 0.05 s apart"),
    (lambda: Disturbances(pushes=[(float(k), 1.0) for k in range(10_001)]), "number of pushes = 10001"),
    (lambda: Disturbances(push_impulse=1.0), "random pushes need both"),
    (lambda: Disturbances(push_impulse=1.0, push_interval=1.0, pushes=[(1.0, 1.0)]), "at given times or random ones"),
    (lambda: Disturbances(delay=0.01).delay_ticks(0.004), "a multiple of the control period 0.004 s"),
    (lambda: Disturbances(delay=0.3).delay_ticks(0.001), "at most 256 control periods"),
    (lambda: Disturbances(control_period=2e-3).period(1e-3, 1e-3), "control_period = 0.002 of disturbances .* contra"),
    (lambda: walk("mujoco", control_period=0.0015), "control_period = 0.0015: must be a multiple of the timestep"),
    (lambda: walk("hybrid", friction=0.1), "the hybrid engine's stance foot never slips"),
    (lambda: walk(OWN, delay=0.1), "the engine own knows no disturbances"),
    (lambda: mjbiped.walk(PassiveController(), GROUND, disturbances={}), "got dict"),  # type: ignore[arg-type]
    (lambda: disturbances_of([("angl_noise", "1")], []), "--disturb unknown .*did you mean 'angle_noise'"),
    (lambda: study(delay=[0.01, 0.0105]), r"cell 1 \(disturbances.delay = 0.0105\): delay = 0.0105"),
]


@pytest.mark.parametrize(("asked", "said"), REFUSED, ids=[said for _, said in REFUSED])
def test_what_makes_no_sense_is_refused(asked: Any, said: str) -> None:
    with pytest.raises(mjbiped.InputError, match=said):
        asked()


def test_a_delay_is_a_whole_number_of_control_periods_of_which_one_holds() -> None:
    late = Disturbances(delay=0.012)
    assert late.delay_ticks(0.004) == 3
    assert [late.period(*each) for each in ((None, 1e-4), (None, 4e-3), (2e-3, 1e-3))] == [1e-3, 4e-3, 2e-3]
    assert Disturbances(control_period=2e-3).period(2e-3, 1e-3) == 2e-3


def test_a_record_says_what_is_not_as_usual_and_options_say_the_same() -> None:
    given = Disturbances(angle_noise=0.01, pushes=[(1, 2), (3.0, -4.0)], seed=2**64 - 1)
    assert given.to_dict() == {"angle_noise": 0.01, "pushes": [[1.0, 2.0], [3.0, -4.0]], "seed": 2**64 - 1}
    assert Disturbances.from_dict(given.to_dict()) == given
    assert UNDISTURBED.to_dict() == {}
    options = disturbances_of([("angle_noise", "0.01"), ("seed", "7"), ("torque_limit", "none")], [(2.0, -5.0)])
    assert options == Disturbances(angle_noise=0.01, seed=7, pushes=((2.0, -5.0),))
    assert disturbances_of([], []) is None
    assert disturbances_of([("torque_limit", "30, 20")], []) == Disturbances(torque_limit=(30.0, 20.0))


def test_a_model_error_is_a_factor_of_what_the_robot_is() -> None:
    robot = mjbiped.Compass(hip_mass=3.0)
    model = model_of(robot, [("leg_mass", 1.2), ("hip_mass", 0.5)])
    assert (model.leg_mass, model.hip_mass) == (1.2 * robot.leg_mass, 1.5)
    assert model.leg_inertia == robot.leg_inertia


def test_a_study_varies_disturbances_and_a_summary_has_them() -> None:
    found = study(delay=[0.0, 0.05], torque_limit="none")
    assert found.varied == ("disturbances.delay",)
    prompt, late = (cell.walk() for cell in found.cells)
    assert "disturbances" not in prompt.settings
    assert late.settings["disturbances"] == {"delay": 0.05}
    assert late.peak_torque.max() > prompt.peak_torque.max()
    weak = study(torque_limit=["30,20"]).cells[0].walk()
    for walked, told in ((late, "delay 0.05"), (weak, "torque limit 30,20")):
        assert ("disturbances", told, "") in walked.summary().rows


def test_a_foot_slips_where_the_friction_is_less_than_the_walk_asks_for() -> None:
    """Passive walking asks for |F_t / F_n| of 0.2 (docs/gaits.md); on ice of 0.1 no foot exerts more."""
    free = walk("mujoco")
    asked = free.touchdowns["friction"].max()
    assert 0.15 < asked < 0.25
    # the solver's cone is another, and what it has computed with it is the same to its tolerance
    held = walk("mujoco", friction=1.2 * asked)
    np.testing.assert_allclose(held.touchdowns["q"], free.touchdowns["q"], atol=1e-10)
    ice = walk("mujoco", friction=0.1)
    assert ice.outcome in ("slipped", "fell")
    assert ice.settings["disturbances"] == {"friction": 0.1}


def test_friction_goes_along_with_a_window_of_the_ground() -> None:
    """A long terrain is built piece by piece."""
    begin: Any = {"robot": mjbiped.Compass(), "q": (-0.19, 0.19), "dq": (1.1, 0.8), "steps": 3}
    ground = mjbiped.Terrain.random(seed=1, length=200.0)
    simulation = make_simulation(PassiveController(), ground, disturbances=Disturbances(friction=0.3), **begin)
    for _ in range(2):
        feet = [leg.foot for leg in simulation.constants.legs]
        assert simulation.model.geom_friction[feet, 0].tolist() == [0.3, 0.3]
        simulation.data.qpos[0] = simulation.inside[1] + 0.1
        assert simulation.move_on()


@pytest.mark.parametrize("seed", [0, 2**63 + 5])
def test_random_numbers_are_distributed_as_they_say(seed: int) -> None:
    """Kolmogorov and Smirnov's test, by scipy; a sound generator fails one in 10^4 of these, and none here."""
    words, count = chance.words_of(seed), 20_000
    uniform = [chance.uniform(words, number, 7) for number in range(count)]
    normal, other = (np.array([chance.normal(words, n, channel) for n in range(count)]) for channel in (3, 4))
    assert 0.0 < min(uniform) < max(uniform) < 1.0
    assert stats.kstest(uniform, "uniform").pvalue > 1e-4
    assert stats.kstest(normal, "norm").pvalue > 1e-4
    four = 4.0 / math.sqrt(count)  # deviations of a correlation of independent numbers
    for a, b in ((normal[1:], normal[:-1]), (normal, other)):
        assert abs(np.corrcoef(a, b)[0, 1]) < four


def normal(low: int, high: int, number: int, channel: int) -> float:
    return chance.normal(chance.Seed(low, high), number, channel)


def test_random_numbers_are_murmurhash3s_and_the_same_compiled() -> None:
    """What records and studies of before were drawn by; the products against Python's, which do not overflow."""
    from mjbiped.numerics.machine import compiled

    assert chance.uniform(chance.words_of(5), 3, 2) == (fmix(fmix(fmix(fmix(5, 0), 2), 3), 0) + 0.5) / 2**32
    asked = compiled(normal, "float64(int64, int64, int64, int64)")
    for seed in (0, 2**64 - 1, 987654321987):
        for number in (0, 1, 2**31, 2**40 + 3):
            words = chance.words_of(seed)
            assert asked(*words, number, 3) == chance.normal(words, number, 3)


def fmix(before: int, word: int) -> int:
    """MurmurHash3's fmix32 of a word after another."""
    x = ((before ^ word) + 0x9E3779B9) % 2**32
    x = (x ^ x >> 16) * 0x85EBCA6B % 2**32
    x = (x ^ x >> 13) * 0xC2B2AE35 % 2**32
    return x ^ x >> 16
