"""Feet that are bodies in the hybrid engine: flat they walk as soles do; they tip, turn, and come down."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from simulations import hybrid_run

import mjbiped
from controllers import BoundedAnkleController
from mjbiped.control.controller import Unpowered
from mjbiped.engines.hybrid.engine import HybridRun
from mjbiped.engines.hybrid.setup import raised
from mjbiped.robots.robot import Robot

FOOTED = mjbiped.FootedCompass()
SOLED = mjbiped.Compass(sole=FOOTED.sole)
GAIT = mjbiped.find_passive_gait(SOLED.mechanism, slope=np.deg2rad(2))
START: dict[str, Any] = {"q": tuple(GAIT.start[:2]), "dq": tuple(GAIT.start[2:])}
EXACT = 1e-8  # of states after some steps: the tolerance of an integration step
GROUNDS = {
    "down": mjbiped.Terrain.incline(2.0),
    "level": mjbiped.Terrain.level(),
    "less steep": mjbiped.Terrain.from_segments([(0.3, 2.0, 0.0), (5.0, 0.5, 0.0)]),
    "stairs": mjbiped.Terrain.stairs(tread=1.8, rise=-0.03),
}


class Pulse(Unpowered):
    """A pulse of the ankle's torque: half a sine wave."""

    def __init__(self, size: float, begin: float, end: float) -> None:
        self.size, self.begin, self.end = size, begin, end

    def torque(self, memory: Any, t: float, q: Any, dq: Any) -> tuple[float, float]:
        share = (t - self.begin) / (self.end - self.begin)
        return (self.size * math.sin(math.pi * share) if 0.0 < share < 1.0 else 0.0), 0.0

    def law(self) -> None:  # type: ignore[override]  # its methods are called
        return None


TOE_PULSE, HEEL_PULSE = Pulse(-14.0, 0.2, 0.3), Pulse(12.5, 0.02, 0.08)


def run_of(controller: Any, ground: str = "down", robot: Robot = FOOTED, **terms: Any) -> HybridRun:
    return hybrid_run(controller, GROUNDS[ground], robot=robot, compile=False, **{**START, "steps": 2, **terms})


def walked(controller: Any, ground: str = "down", **terms: Any) -> tuple[HybridRun, dict[str, Any], dict[str, Any]]:
    """A walk, its samples and its touchdowns."""
    run = run_of(controller, ground, **terms)
    run.walk(lambda *_: None)
    return run, run.recorder.samples(), run.recorder.touchdowns()


@pytest.mark.parametrize("ground", ["down", "level", "stairs"])
def test_a_foot_that_stays_flat_walks_as_a_sole_does(ground: str) -> None:
    times, states = [], []
    for robot in (FOOTED, SOLED):
        run = run_of(BoundedAnkleController(robot, GAIT), ground, robot)
        run.walk(lambda *_: None)
        angles = run.constants.angles
        states.append([*run.state.y[:2], *run.state.y[angles : angles + 2]])
        times.append(run.state.time)
    np.testing.assert_allclose(states[0], states[1], atol=10 * EXACT)
    assert times[0] == pytest.approx(times[1], abs=EXACT)


@pytest.mark.parametrize(("pulse", "sign"), [(TOE_PULSE, 1.0), (HEEL_PULSE, -1.0)])
def test_a_foot_tips_and_comes_down(pulse: Pulse, sign: float) -> None:
    _, samples, touchdowns = walked(pulse, steps=1, sample_period=0.002)
    slope = GROUNDS["down"].slope_at(0.0)
    out = samples["time"] < touchdowns["time"][0]
    tip, places = sign * (samples["slope"] - slope)[out], samples["qpos"][out]
    assert tip.min() >= 0.0
    assert 1e-3 < tip.max() <= touchdowns["tipped"][0] < 0.1
    assert tip.max() == pytest.approx(touchdowns["tipped"][0], rel=0.02)  # between samples
    assert touchdowns["one_sided"][0] == pytest.approx(0.002 * np.count_nonzero(tip > 0.0), abs=0.004)
    np.testing.assert_allclose(places[:, 2] + places[:, 4], samples["slope"][out], atol=1e-12)  # the left foot's sole
    np.testing.assert_allclose(places[:, 2] - samples["slope"][out], samples["q"][out, 0], atol=1e-12)
    end = touchdowns["pressure_ahead" if sign > 0 else "pressure_behind"][0]
    assert end == pytest.approx(0.12, abs=1e-7)  # the moment of tipping is known to 1e-9 s
    edge = FOOTED.outline(places)[:, 0, -1 if sign > 0 else -2]
    np.testing.assert_allclose(edge - edge[0], 0.0, atol=1e-9)  # it stays where it is


def test_segments_are_raised_along_their_normals() -> None:
    terrain = mjbiped.Terrain.from_segments([(1.0, 2.0, 0.0), (1.3, -4.0, 0.0), (1.0, 3.0, 0.05), (2.0, 3.0, 0.0)])
    ground, height = raised(terrain, 0.02), 0.02
    for i, angle in enumerate(terrain.angle):
        x = terrain.x[i] + 0.5
        over = ground.z[i] + ground.gradient[i] * (x + height * math.sin(angle) - ground.x[i])
        assert over == pytest.approx(terrain.z[i] - 0.5 * math.tan(angle) + height * math.cos(angle), abs=1e-15)
    before = ground.z[0] + ground.gradient[0] * (ground.x[1] - ground.x[0])
    assert ground.z[1] == pytest.approx(before, abs=1e-15)  # no riser where there was none
    assert ground.x[2] == terrain.x[2]  # a riser stays
