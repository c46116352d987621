"""Whole walks in MuJoCo: does the paper's controller do in a rigid-body simulator what the paper says it does?

Expected figures are those of the analytic model (design figures, confirmed by an independent hybrid simulation), not of
an earlier run of this engine.
"""

import dataclasses
import math

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.records import measures
from mjbiped.terrain.terrain import Terrain

STEPS = 60
FEWER = 36  # over ten treads or slope segments

# Distance between a discrete contact and an instantaneous one. The rates after an impact are those of the impact map
# plus 2e-5 s of motion at up to 30 rad/s², 6e-4 rad/s of 0.8 rad/s, and what a stance foot falls that happens to be out
# of contact in the approach (see `mjbiped.engines.mujoco.step_size`): g times 2e-4 s, 2e-3 m/s of 0.8 m/s.
IMPACT = 3.2e-3
# A step of length t = 2e-4 s holds the stance foot at its beginning: the foot moves by t l q̇² / 2 per second, in the
# 0.8 s of a fast step (q̇ up to 1.5 rad/s) by 1.8e-4 m, half of it along the ground at most.
SLIP = 1e-4
# A landing leads 1e-6 m into the ground; a foot that is caught again has fallen by g t² = 4e-7 m.
PENETRATION = 3e-6


@pytest.fixture(scope="module")
def passive() -> mjbiped.Walk:
    return mjbiped.walk(PassiveController(), Terrain.incline(2.0), steps=FEWER)


def test_passive_walk_is_the_analytic_limit_cycle(passive: mjbiped.Walk, gait: mjbiped.Gait) -> None:
    assert (passive.outcome, passive.steps) == ("finished", FEWER)
    # one touchdown is quantised to h (1e-4 s of 0.76 s); the mean over 30 is better than that
    assert measures.step_lengths(passive)[-30:].mean() == pytest.approx(gait.step_length, rel=1e-3)
    assert measures.step_periods(passive)[-30:].mean() == pytest.approx(gait.period, rel=1e-3)


def test_passive_walk_has_the_impacts_of_the_impact_map(passive: mjbiped.Walk) -> None:
    assert np.abs(measures.impact_errors(passive)).max() < IMPACT


def test_passive_walk_neither_slips_nor_sinks(passive: mjbiped.Walk) -> None:
    assert passive.touchdowns["slip"].max() < SLIP
    assert passive.touchdowns["penetration"].max() < PENETRATION
    assert passive.touchdowns["friction"].max() < 0.8


def test_passive_walk_costs_nothing(passive: mjbiped.Walk) -> None:
    assert passive.cost_of_transport == 0.0
    assert not passive.samples["torque"].any()


# terrain, c_mt, peak torque of ankle (N m); design figures of section 6 and the tables of the docs
CLOSED_LOOP = {
    "level": (Terrain.level(), 0.0349, 1.75),
    "down 3": (Terrain.incline(3.0), 0.0176, 1.7),
    "up 3": (Terrain.incline(-3.0), 0.0875, 5.1),
    "slopes +0.3": (Terrain.slopes(change_deg=0.3), None, None),
    "slopes -1": (Terrain.slopes(change_deg=-1.0), None, None),
    "stairs -0.006": (Terrain.stairs(rise=-0.006), 0.0341, 3.0),
    "stairs +0.006": (Terrain.stairs(rise=0.006), None, None),
    "stairs -0.06": (Terrain.stairs(rise=-0.06), 0.0818, 33.0),
    "mixed": (Terrain.mixed(), None, None),
}


@pytest.mark.parametrize(
    ("name", "steps"),
    [
        # the mean over stairs of 60 mm, five steps a tread or four, is the design's after its 45 steps
        *((name, 45 if name == "stairs -0.06" else FEWER) for name in CLOSED_LOOP),
        *(pytest.param(name, STEPS, marks=pytest.mark.slow) for name in CLOSED_LOOP),
    ],
)
def test_closed_loop(name: str, steps: int, controller: AdaptiveController) -> None:
    terrain, cost, torque = CLOSED_LOOP[name]
    walk = mjbiped.walk(controller, terrain, steps=steps)
    assert (walk.outcome, walk.steps) == ("finished", steps)
    started, _ = measures.estimate_errors(walk)
    assert abs(started[-1]) < math.radians(0.1)
    assert np.abs(measures.impact_errors(walk)).max() < IMPACT
    assert walk.touchdowns["penetration"].max() < PENETRATION
    assert walk.touchdowns["slip"].max() < SLIP
    assert not walk.touchdowns["strikes"].any()
    if cost is not None:
        # both engines agree within 0.3 % of c_mt, and the design gives its figures to three digits
        assert walk.cost_of_transport == pytest.approx(cost, rel=5e-3)
        assert walk.peak_torque[0] == pytest.approx(torque, rel=0.03)
    if name == "level":
        assert walk.cost_of_transport == pytest.approx(math.sin(math.radians(2)), abs=3e-4)


@pytest.mark.parametrize("slope_deg", [-3.0, 0.0, 3.0])
def test_starts_by_itself_from_rest(slope_deg: float, controller: AdaptiveController) -> None:
    """The paper's X = [0, 0, 0, 0]: both legs together, at rest, the slope's estimate at zero."""
    walk = mjbiped.walk(controller, Terrain.incline(slope_deg), steps=6, initial="rest")
    assert (walk.outcome, walk.steps) == ("finished", 6)
    started, _ = measures.estimate_errors(walk)
    assert abs(started[-1]) < math.radians(0.1)


@pytest.mark.parametrize(
    "terrain", [Terrain.slopes(change_deg=0.6), Terrain.random(seed=5, rise=(0.0, 0.0), roughness=0.003)]
)
def test_heightfield_and_boxes_agree(terrain: Terrain, controller: AdaptiveController) -> None:
    as_heightfield = mjbiped.walk(controller, terrain, steps=12, engine=mjbiped.Mujoco(ground="heightfield"))
    as_boxes = mjbiped.walk(controller, terrain, steps=12, engine=mjbiped.Mujoco(ground="boxes"))
    assert as_heightfield.outcome == as_boxes.outcome == "finished"
    # float32 heights: 1e-7 m of a step of 0.4 m
    assert as_heightfield.cost_of_transport == pytest.approx(as_boxes.cost_of_transport, rel=1e-5)
    assert as_heightfield.distance == pytest.approx(as_boxes.distance, abs=1e-5)


def test_flat_heightfield_is_a_plane(controller: AdaptiveController) -> None:
    plane, heightfield = (
        mjbiped.walk(controller, Terrain.level(), steps=8, engine=mjbiped.Mujoco(ground=ground))
        for ground in ("auto", "heightfield")
    )
    # the contact's geometry is computed by other code, to the last bits of a metre
    assert heightfield.samples["qpos"] == pytest.approx(plane.samples["qpos"], abs=1e-8)
    assert heightfield.cost_of_transport == pytest.approx(plane.cost_of_transport, rel=1e-8)


def test_slower_controller_still_walks(controller: AdaptiveController) -> None:
    """A digital controller at 500 Hz: the estimator's Euler step and the held torque are four times as coarse."""
    walk = mjbiped.walk(controller, Terrain.level(), steps=10, engine=mjbiped.Mujoco(control_period=2e-3))
    assert walk.outcome == "finished"
    # torque held for 2 ms lags by 1 ms of a gait of 0.76 s
    assert walk.cost_of_transport == pytest.approx(math.sin(math.radians(2)), rel=0.02)


def test_estimates_of_a_slower_controller_are_those_of_their_own_touchdown(controller: AdaptiveController) -> None:
    """It takes notice of a touchdown some physics steps later; the rows once held the touchdown's before."""
    walk = mjbiped.walk(
        controller,
        Terrain.slopes(change_deg=1.5),
        steps=5,
        engine=mjbiped.Mujoco(control_period=5e-3),
        sample_period=1e-4,
    )
    touchdowns, samples = walk.touchdowns, walk.samples
    for row, time in enumerate(touchdowns["time"]):
        last = np.flatnonzero(samples["time"] < time)[-1]
        # its estimate goes on at the rate held, for up to 5 ms; the touchdown's before would be off by a degree
        assert touchdowns["slope_estimate_before"][row] == pytest.approx(samples["slope_estimate"][last], abs=1e-6)
    change = touchdowns["q_before"][:, 0] - touchdowns["q"][:, 1]
    update = touchdowns["slope_estimate"] - touchdowns["slope_estimate_before"]
    assert np.abs(change).max() > np.radians(1)
    # (27) leaves out what is under its threshold
    assert update == pytest.approx(change, abs=controller.update_threshold)


def test_robot_may_differ_from_the_model(controller: AdaptiveController) -> None:
    heavier = mjbiped.Compass(leg_mass=5.2)
    walk = mjbiped.walk(controller, Terrain.level(), steps=5, robot=heavier)
    assert walk.robot == heavier
    assert walk.outcome == "finished"


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("roughness", [0.0, 0.003])
def test_random_terrain(seed: int, roughness: float, controller: AdaptiveController) -> None:
    walk = mjbiped.walk(controller, Terrain.random(seed=seed, roughness=roughness), steps=STEPS)
    assert walk.outcome == "finished"
    assert np.abs(measures.impact_errors(walk)).max() < IMPACT


def test_a_foot_that_slides_is_told(controller: AdaptiveController) -> None:
    """Without re-planning a step down of 6 cm asks for more friction than there is: a foot slides by 15 mm."""
    unplanned = dataclasses.replace(controller, replanning_delay=None)
    slid = mjbiped.walk(unplanned, mjbiped.Terrain.stairs(rise=-0.06), steps=4)
    (told,) = slid.warnings
    assert "slid by more than 0.001 leg lengths" in told
    assert slid.warnings[told] == np.count_nonzero(slid.touchdowns["slip"] > 1e-3)
    assert slid.verdict == measures.THROUGH_VIOLATING
    stood = mjbiped.walk(controller, mjbiped.Terrain.stairs(rise=-0.06), steps=4)
    assert (dict(stood.warnings), stood.verdict) == ({}, measures.THROUGH)
