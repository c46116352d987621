"""The hybrid engine comes to an end whatever the controller does, says why, and can be interrupted at any time."""

import _thread
import dataclasses
import math
import threading
import time

import pytest
from simulations import Torques
from time_limits import within

import mjbiped
from controllers import AdaptiveController, Memory, PassiveController
from mjbiped.engines.hybrid.guards import ATTEMPTS_BETWEEN_LOOKS
from mjbiped.terrain.terrain import Terrain

INCLINE = Terrain.incline(2.0)
START = (-0.19, 0.19, 1.1, 0.8)


def switching(torque: float) -> Torques:
    """Brakes the legs against each other: it brings their relative rate to zero, and then switches to and fro."""
    return Torques(lambda _, __, dq: (0.0, -math.copysign(torque, dq[1] - dq[0])))


def test_torque_that_switches_without_end_is_unresolved() -> None:
    law = switching(10.0)
    with within(60.0, "a torque that switches"):  # some 0.5 s; it once never ended
        walk, again = (mjbiped.walk(law, INCLINE, engine="hybrid", initial=START, steps=5) for _ in range(2))
    assert (walk.outcome, walk.fell) == ("unresolved", False)
    ((message, count),) = walk.warnings.items()
    assert ("next_discontinuity" in message, count) == (True, 1)
    assert 0.01 < walk.end[0] < 2.0  # where the switching begins
    assert walk == again


def test_torque_that_switches_now_and_then_is_resolved() -> None:
    walk = mjbiped.walk(switching(0.1), INCLINE, engine="hybrid", initial=START, steps=3)
    assert (walk.outcome, dict(walk.warnings)) == ("finished", {})


def test_many_short_steps_that_advance_are_no_reason_to_end() -> None:
    """A stiff brake holds the legs together until the robot falls, by some 5000 steps of the integration."""
    brake = Torques(lambda _, __, dq: (0.0, -2e4 * (dq[1] - dq[0])))
    assert mjbiped.walk(brake, INCLINE, engine="hybrid", initial=START).outcome == "fell"


def test_robot_that_flies_apart_has_diverged() -> None:
    """Rates that grow beyond all bounds in a finite time: no step is short enough, but nothing switches."""
    runaway = Torques(lambda _, __, dq: (100.0 * dq[1] ** 3, 100.0 * dq[1] ** 3))  # on the swing leg alone
    walk = mjbiped.walk(runaway, INCLINE, engine="hybrid", initial=START)
    assert walk.outcome == "diverged"
    assert dict(walk.warnings) == {"torques or motion are beyond all bounds, or no numbers": 1}


def test_breaks_without_end_are_unresolved() -> None:
    class Crowded(PassiveController):
        def next_discontinuity(self, memory: Memory, t: float) -> float:
            return t + 1e-9

    walk = mjbiped.walk(Crowded(), INCLINE, engine="hybrid", initial=START)
    assert walk.outcome == "unresolved"
    assert walk.end[0] == 0.0 or walk.samples["time"][-1] == pytest.approx(1e-9 * ATTEMPTS_BETWEEN_LOOKS, rel=1e-3)


@pytest.mark.compiled
def test_compiled_walk_can_be_interrupted(controller: AdaptiveController) -> None:
    mjbiped.walk(controller, Terrain.level(), engine="hybrid", steps=1)  # compiled now
    # tens of thousands of integration steps for a gait step, some 40 ms compiled
    stiff, started = dataclasses.replace(controller, velocity_gain=2e5), time.perf_counter()
    threading.Timer(0.5, _thread.interrupt_main).start()  # as Ctrl-C does
    with pytest.raises(mjbiped.WalkInterrupted) as caught:
        mjbiped.walk(stiff, Terrain.level(), engine="hybrid", steps=100_000, sample_period=None)
    # a stint is shorter than 0.1 s; the rest is for a machine under load. It once came after 1024 gait steps
    assert time.perf_counter() - started < 3.0
    walk = caught.value.walk
    assert walk.outcome == "interrupted"
    assert walk.steps > 0
    assert walk.end[0] >= walk.touchdowns["time"][-1]
