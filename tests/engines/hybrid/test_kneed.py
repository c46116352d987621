"""A swing foot with a knee that meets the ground and cannot take the robot over: it slides, and strikes faces."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from simulations import hybrid_simulation

from mjbiped import KneedBiped, Terrain
from mjbiped.dynamics.modes import FREE, LOCKED
from mjbiped.engines.hybrid.motion import enter_mode, rates
from mjbiped.engines.hybrid.resets import note_face
from mjbiped.rules.termination import Outcome

Array = NDArray[np.float64]
ROBOT = KneedBiped()
START = (-0.24, 0.24, 0.24, 1.10, 0.33, 0.33)
"""Near the gait on 2.5 degrees, and not on it."""


NORMALS = [(-1.0, 0.0), (math.sin(0.03), math.cos(0.03))]
"""Of a riser ahead, and of ground on a slope."""


@pytest.mark.parametrize("normal", NORMALS)
@pytest.mark.parametrize("locked", [FREE, LOCKED])
def test_a_foot_in_contact_stays_in_it(locked: int, normal: tuple[float, float]) -> None:
    """Newton's law with the robot's matrices: a force along the normal; the foot is not accelerated along it."""
    slope, force = 0.05, np.array([3.0, -2.0, 0.5])
    n = 3 if locked == FREE else 2
    run = hybrid_simulation(Terrain.level(), START)
    c, w = run.constants, run.state
    w.slope, w.locked, w.face, w.sliding = slope, locked, float(normal[1] == 0.0), normal[1] != 0.0
    w.sine, w.cosine = math.sin(slope), math.cos(slope)
    enter_mode(c, w)
    w.pushed_x, w.pushed_z = normal
    q, dq = np.array([0.1, -0.2, 0.1 if n == 3 else -0.2]), np.array([1.0, 2.0, -1.5 if n == 3 else 2.0])
    force[2] *= n == 3
    hip = force[1] + force[2]
    torque = [force[0] + hip, hip, force[2]]
    c.torque = lambda *arguments: arguments[-1].__setitem__(slice(3), torque)
    changes = [0.0] * 9
    rates(c, w, 0.0, [*q, *dq, 0.0, 0.0, 0.0], changes)
    ddq, q, dq = np.array(changes[3 : 3 + n]), q[:n], dq[:n]
    reach = ROBOT.chains[n].reach
    row = reach * (np.cos(q + slope) * normal[0] - np.sin(q + slope) * normal[1])
    bend = reach * (np.sin(q + slope) * normal[0] + np.cos(q + slope) * normal[1])
    assert row @ ddq - bend @ dq**2 == pytest.approx(0.0, abs=1e-12)
    residual = ROBOT.mass_matrix(q) @ ddq + ROBOT.coriolis_matrix(q, dq) @ dq + ROBOT.gravity_vector(q, slope)
    residual -= force[:n] if n == 3 else [force[0], force[1]]
    assert residual == pytest.approx(row * (residual @ row) / (row @ row), abs=1e-10)
    assert w.press == pytest.approx((residual @ row) / (row @ row), abs=1e-10)


def test_a_foot_that_cannot_leave_the_ground_slides_until_it_is_lifted() -> None:
    """A stub behind the stance foot is no end: one impact, then contact without friction or work, then a step."""
    rising, falling = (Terrain((-5.0, -0.39), (0.0, 0.0), (0.0, math.radians(angle))) for angle in (-1.0, 1.0))
    for ground, stubs, slid in ((Terrain.level(), 1, 20), (rising, 2, 20), (falling, 1, 1)):  # slides on, or off
        start = (-0.2, 0.201, 0.201, 1.0, -1.5, -1.5)
        simulation = hybrid_simulation(ground, start, sample_period=1e-3, steps=1)
        simulation.go()
        assert simulation.outcome is Outcome.FINISHED
        recorder = simulation.recorder
        samples = recorder.samples()
        foot = ROBOT.limbs(samples["qpos"])[:-1, 1, -1]
        height = foot[:, 1] - [ground.height_at(x) for x in foot[:, 0]]
        slides = np.flatnonzero(height < 1e-9)
        assert len(slides) >= slid
        assert (np.diff(slides) == 1).all()
        assert np.abs(height[slides]).max() < 1e-10  # 8th order in steps of 2 ms, which hold accelerations
        assert recorder.touchdowns()["stubs"][0] == stubs
        slope = ground.slope_at(0.0)
        energy = [ROBOT.energy(q, dq, slope) for q, dq in zip(samples["q"], samples["dq"], strict=True)]
        assert energy[slides[0]] < energy[0] - 1e-4
        if stubs == 1 and slid > 1:
            assert np.ptp(energy[slides[0] : slides[-1]]) < 1e-8


@pytest.mark.parametrize("beyond", [0.0, 1e-10])
def test_a_foot_released_at_the_base_of_a_riser_does_not_pass_through_it(beyond: float) -> None:
    """However rounding lays it about the face: it strikes the face, and rises along it before it goes on."""
    face, rise, leg = -0.3, 0.03, -0.3
    ground = Terrain((-5.0, face), (-rise, 0.0), (0.0, 0.0))
    hip = np.array([math.sin(leg), math.cos(leg)])

    way = hip - [face + beyond, -rise]
    lean, half = math.atan2(*way), math.acos(np.hypot(*way) / ROBOT.leg_length)  # of two links of equal length
    thigh, shank = lean - half, lean + half
    simulation = hybrid_simulation(ground, (leg, thigh, shank, 1.5, -2.0, -1.0), sample_period=1e-3, steps=1)
    note_face(simulation.constants, simulation.state, 0, face + beyond)  # as the transfer to the other foot does
    simulation.go()
    recorder = simulation.recorder
    feet = ROBOT.limbs(recorder.samples()["qpos"])[:-1, 1, -1]
    clear = np.flatnonzero(feet[:, 1] > 1e-8)  # over the tread
    assert feet[: clear[0], 0].max() < face + 1e-8
    assert len(clear) > 10
    assert simulation.state.face_impacts or recorder.touchdowns()["strikes"][0]


def test_a_sliding_foot_ahead_whose_knee_strikes_takes_the_robot_over() -> None:
    q = np.array([0.0, -0.3, -0.2995])
    q[0] = math.acos(0.5 * (math.cos(q[1]) + math.cos(q[2])))  # both feet are on the ground
    row = -ROBOT.chains[3].reach * np.sin(q)  # upward
    thigh = -(row[0] * -0.5 + row[2] * -1.0) / (row[1] + row[2])
    simulation = hybrid_simulation(Terrain.level(), (*q, -0.5, thigh, thigh - 1.0), steps=1)
    w = simulation.state
    w.sliding, w.slid_segment, w.pushed_z = True, 0, 1.0
    simulation.go()
    assert simulation.outcome is Outcome.FINISHED
    touched = simulation.recorder.touchdowns()
    assert 0.0 < touched["knee_strike"][0] == touched["time"][0] < 1e-3
