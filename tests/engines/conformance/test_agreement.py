"""The engines' agreement: the same touchdowns, works and forces from impact maps and from contacts."""

import math
from dataclasses import replace

import numpy as np
import pytest
from engines.conformance.cases import UNDISTURBED, contact_step, parametrised, softness, walk_of
from golden_walks import Case

import mjbiped
from controllers import AdaptiveController
from mjbiped.records import measures

Terrain = mjbiped.Terrain
STRUCK = Case("compass", "adaptive", "riser", "mujoco")
PAIRS = [case for case in UNDISTURBED if case.engine != "hybrid" and case != STRUCK]


@parametrised(PAIRS)
def test_first_steps(case: Case) -> None:
    """An impact leaves an error of a contact step's motion, which each step of the gait enlarges up to threefold.

    So within ten contact steps.
    """
    there, here = walk_of(case), walk_of(case._replace(engine="hybrid"))
    found, wanted, n = there.touchdowns, here.touchdowns, there.steps
    late = 10.0 * softness(case) * contact_step(case)  # s
    power = here.robot.weight * math.sqrt(here.robot.gravity * here.robot.leg_length)
    # speeds; MuJoCo's forces are averages over 5 ms
    limits = {"time": late, "x": late, "q": 1.5 * late, "dq": 10.0 * late, "work_net": 0.1 * late * power}
    limits |= dict.fromkeys(("stance", "slope", "strikes"), 1e-4) | {"normal_force": 0.03 * here.robot.weight}
    limits |= {"knee_strike": late, "flexion": 1e-3} if "knee_strike" in found else {}
    for name, limit in limits.items():
        np.testing.assert_allclose(found[name], wanted[name][:n], rtol=0, atol=limit, err_msg=name)


@pytest.mark.parametrize(
    ("first", "rise"), [(1.0, 0.045), (1.02, 0.04), (1.115, -0.06)], ids=["slides", "higher", "down"]
)
def test_faces(first: float, rise: float, controller: AdaptiveController) -> None:
    """A foot strikes a riser ahead, or from above in its backward swing: MuJoCo's stance foot slips, by 0.7 mm."""
    terrain = Terrain.stairs(rise=rise, first=first, count=1)
    here, there = (mjbiped.walk(controller, terrain, engine=engine, steps=5) for engine in ("hybrid", "mujoco"))
    assert here.outcome == there.outcome == "finished"
    assert here.touchdowns["strikes"].tolist() == there.touchdowns["strikes"].tolist() == [0, 0, 1, 0, 0]
    assert there.touchdowns["x"] == pytest.approx(here.touchdowns["x"], abs=1e-3)
    assert there.cost_of_transport == pytest.approx(here.cost_of_transport, rel=0.01)
    assert there.peak_torque == pytest.approx(here.peak_torque, rel=0.035)
    assert here.touchdowns["x"][2] == pytest.approx(first, abs=1e-7)


@pytest.mark.parametrize("share", [0.5, 0.6, 0.7, 0.8])
def test_a_riser_that_is_struck_costs_both_engines_their_contact(share: float, controller: AdaptiveController) -> None:
    """The impulse lifts the stance foot: MuJoCo's hops and slides by 4 mm, the hybrid engine's ground has to pull."""
    place = (4.0 + share) * controller.gait.step_length
    ground = Terrain.from_segments([(place, 0.0, 0.0), (1.0, 0.0, 0.04)])
    for engine in ("hybrid", "mujoco"):
        walk = mjbiped.walk(controller, ground, engine=engine, steps=7)
        assert walk.touchdowns["strikes"].any() == walk.contact_violations.any() == (share in (0.6, 0.7)), engine


PRESETS = {
    "level": Terrain.level(),
    "down 3": Terrain.incline(3.0),
    "slopes +0.3": Terrain.slopes(change_deg=0.3),
    "slopes -1": Terrain.slopes(change_deg=-1.0),
    "stairs +0.006": Terrain.stairs(rise=0.006),
    "stairs -0.06": Terrain.stairs(rise=-0.06),
    "mixed": Terrain.mixed(),
    **{f"random {seed}": Terrain.random(seed=seed, roughness=0.002 * (seed % 3)) for seed in range(30)},
}


@pytest.mark.slow
@pytest.mark.parametrize("name", PRESETS)
def test_whole_walks(name: str, controller: AdaptiveController) -> None:
    """To the limits that were asked for; where random grounds part the engines there must be a cause.

    The law re-plans each step: with its threshold one engine re-plans where the other is 1e-4 rad/s short of it.
    """
    walked = mjbiped.compare(replace(controller, replanning_threshold=0.0), PRESETS[name], steps=20)
    there, here = walked.mujoco, walked.hybrid
    assert (there.outcome, there.steps) == (here.outcome, here.steps) == ("finished", 20)
    assert there.cost_of_transport == pytest.approx(here.cost_of_transport, rel=0.005)
    assert there.distance == pytest.approx(here.distance, abs=5e-3)
    assert (np.abs(there.peak_torque - here.peak_torque) < np.maximum(0.15, 0.02 * here.peak_torque)).all()
    for walk in (there, here):
        assert np.degrees(np.abs(measures.estimate_errors(walk)[0][-1])) < (0.1 if "random" not in name else 5.0)
    if walked.divergence is not None:
        assert name.startswith("random")
        assert walked.divergence.causes, walked.verdict
        return
    # what the default steps leave, by the measurement in docs/physics.md: 0.03 mm a step, 1.5e-4 rad
    np.testing.assert_allclose(measures.step_lengths(there), measures.step_lengths(here), rtol=0, atol=1e-4)
    found, wanted = (walk.touchdowns["slope_estimate"] for walk in (there, here))
    np.testing.assert_allclose(found, wanted, rtol=0, atol=3e-4)
    force = (there.touchdowns["normal_force"] - here.touchdowns["normal_force"]) / here.robot.weight
    assert np.abs(force).max() < 0.02
