"""Feet that are bodies in the hybrid engine: flat they walk as soles do; they tip, and come down."""

import math
from typing import Any

import numpy as np
import pytest
from simulations import hybrid_run

import mjbiped
from controllers import BoundedAnkleController, Controller
from mjbiped.engines.hybrid.meeting import clearance_of, clearance_rate
from mjbiped.numerics.blocks import numbers

FOOTED = mjbiped.FootedCompass()
SOLED = mjbiped.Compass(sole=FOOTED.sole)
GAIT = mjbiped.find_passive_gait(SOLED.mechanism, slope=np.deg2rad(2))
EXACT = 1e-8  # of states after some steps: the tolerance of an integration step
DOWN = mjbiped.Terrain.incline(2.0)


class Pulse(Controller):
    """A pulse of the ankle's torque: half a sine wave."""

    def __init__(self, size: float, begin: float, end: float) -> None:
        self.size, self.begin, self.end = size, begin, end

    def torque(self, memory: Any, t: float, q: Any, dq: Any) -> tuple[float, float]:
        share = (t - self.begin) / (self.end - self.begin)
        return (self.size * math.sin(math.pi * share) if 0.0 < share < 1.0 else 0.0), 0.0


def walked(law: Controller, ground: mjbiped.Terrain, **terms: Any) -> mjbiped.Walk:
    return mjbiped.walk(law, ground, engine="hybrid", initial=GAIT.start, **terms)


@pytest.mark.parametrize("ground", [DOWN, mjbiped.Terrain.level(), mjbiped.Terrain.stairs(tread=1.8, rise=-0.03)])
def test_a_foot_that_stays_flat_walks_as_a_sole_does(ground: mjbiped.Terrain) -> None:
    foot, sole = (walked(BoundedAnkleController(robot, GAIT), ground, steps=2) for robot in (FOOTED, SOLED))
    for name in ("q", "dq"):
        np.testing.assert_allclose(foot.touchdowns[name], sole.touchdowns[name], atol=10 * EXACT)
    assert foot.touchdowns["time"] == pytest.approx(sole.touchdowns["time"], abs=EXACT)


@pytest.mark.parametrize(("pulse", "sign"), [(Pulse(-14.0, 0.2, 0.3), 1.0), (Pulse(12.5, 0.02, 0.08), -1.0)])
def test_a_foot_tips_and_comes_down(pulse: Pulse, sign: float) -> None:
    walk = walked(pulse, DOWN, robot=FOOTED, steps=1, sample_period=0.002)
    samples, touchdowns = walk.samples, walk.touchdowns
    out = samples["time"] < touchdowns["time"][0]
    tip, places = sign * (samples["slope"] - DOWN.slope_at(0.0))[out], samples["qpos"][out]
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


@pytest.mark.parametrize(("tilt", "turning"), [(0.3, 0.5), (-0.2, 2.0)])
def test_the_rate_of_a_foots_clearance_is_its_derivative(tilt: float, turning: float) -> None:
    """Of the sole's lower edge, toe or heel, over a slope; central differences err by their width squared."""
    run = hybrid_run(Pulse(1.0, 0.1, 0.2), DOWN, robot=FOOTED, q=(-0.2, 0.2, 0.0, 0.0), dq=(1.0,) * 4, compile=False)
    c, w, width = run.constants, run.state, 1e-5
    y = np.array(numbers(w.y, c.size))
    y[c.foot + 1], y[c.angles + c.foot + 1] = tilt, turning

    def clearance(t: float) -> float:
        moved = y.copy()
        moved[c.foot + 1] += t * turning
        return clearance_of(c, w, moved, 0, 0.4 + 0.6 * t, 0.3 - 0.2 * t)

    rate = clearance_rate(c, w, y, 0, 0.6, -0.2)
    assert (clearance(width) - clearance(-width)) / (2.0 * width) == pytest.approx(rate, abs=1e-9)
    assert clearance(0.0) < 0.3 - DOWN.height_at(0.4) - 0.02  # the edge is below the ankle
