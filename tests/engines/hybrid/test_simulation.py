"""The hybrid engine as an integrator: tolerance, breaks of a law, and torques that are no numbers."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from simulations import hybrid_run

import mjbiped
from controllers import AdaptiveController, Controller, Memory
from mjbiped.engines.hybrid.engine import TOLERANCE
from mjbiped.terrain.terrain import Terrain


def hybrid(controller: Controller, terrain: Terrain, **arguments: Any) -> mjbiped.Walk:
    return mjbiped.walk(controller, terrain, engine="hybrid", **arguments)


def test_tolerance_converges(controller: AdaptiveController, gait: mjbiped.Gait) -> None:
    """Closed loop, re-planned after every step: a thousand times the accuracy changes nothing that matters."""
    ends = []
    for tolerance in (TOLERANCE, 1e-13):
        simulation = hybrid_run(
            controller,
            Terrain.mixed(),
            robot=controller.robot,
            q=gait.start[:2].tolist(),
            dq=gait.start[2:].tolist(),
            steps=12,
            sample_period=None,
            tolerance=tolerance,
        )
        simulation.go()
        ends.append((simulation.recorder.touchdowns(), simulation.peak_torque()))
    (coarse, peak), (fine, fine_peak) = ends
    # issue 3's 1e-9; a walk's errors die out
    assert coarse["q"] == pytest.approx(fine["q"], abs=1e-9)
    assert coarse["dq"] == pytest.approx(fine["dq"], abs=1e-9)
    assert coarse["work_absolute"] == pytest.approx(fine["work_absolute"], rel=1e-6)
    # a peak inside a step is that of a parabola through values a sixteenth of the step apart
    assert peak == pytest.approx(fine_peak, rel=2e-5)


def test_law_with_a_jump_needs_its_break() -> None:
    """No step goes across a break that the controller tells of; without it the same comes out, in more evaluations."""

    class Switch(Controller):
        def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
            return 0.0, (0.5 if t < 0.2 else -0.5)

    class ToldSwitch(Switch):
        def next_discontinuity(self, memory: Memory, t: float) -> float:
            return 0.2 if t < 0.2 else math.inf

    found = []
    for switch in (ToldSwitch(), Switch()):
        simulation = hybrid_run(
            switch, Terrain.incline(2.0), robot=mjbiped.Compass(), q=(-0.19, 0.19), dq=(1.1, 0.8), steps=1
        )
        simulation.go()
        found.append((simulation.recorder.touchdowns()["dq"][0], simulation.state.evaluations))
    (named, few), (unnamed, many) = found
    assert named == pytest.approx(unnamed, abs=10.0 * TOLERANCE)  # some steps near the jump, each within it
    assert few < 0.7 * many


def test_a_torque_that_is_no_number_for_a_moment_leaves_none_in_the_record() -> None:
    """Asked at the ends of integration steps it is one, and in a sample between them it is none."""

    class Gap(Controller):
        def __init__(self, first: float, length: float) -> None:
            self.first, self.last = first, first + length

        def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
            return (math.nan if self.first < t < self.last else 0.0), 0.0

    walks = {"steps": 1, "sample_period": 1e-3}
    starts = {"touches down": (-0.19, 0.19, 1.1, 0.8), "falls": (-0.19, 0.19, 0.3, 0.0)}
    ends = {
        start: hybrid(Gap(9.0, 0.0), Terrain.incline(2.0), initial=start, **walks).end[0] for start in starts.values()
    }
    cases = [(start, first, 2e-3) for start in ends for first in np.linspace(0.05, 0.6, 5)]
    cases += [(start, end - length / 2, length) for start, end in ends.items() for length in (1e-9, 1e-7, 1e-5, 1e-4)]
    outcomes = set()
    for start, first, length in cases:
        walk = hybrid(Gap(first, length), Terrain.incline(2.0), initial=start, **walks)
        assert np.isfinite(walk.samples["q"]).all()
        assert np.isfinite(walk.samples["dq"]).all()
        outcomes.add(walk.outcome)
    assert "diverged" in outcomes
