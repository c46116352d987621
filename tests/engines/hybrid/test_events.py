"""Strikes of the hybrid engine: a swing foot on a riser's face, against the robot's matrices and Newton's law alone."""

import dataclasses
import math

import numpy as np
import pytest
from numpy.typing import NDArray

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.terrain.terrain import Terrain

Array = NDArray[np.float64]
SAMPLE_PERIOD = 1e-5
FACE, RISE = 1.12, 0.04


class SwingFoot:
    """The swing foot in one step on level ground, at samples; `first` and `last` are those on the face.

    Args:
        walk: A record with samples every 10 us.
        step: Which step, from 0; its stance foot stands on level ground.
        face: Where the riser stands, m.
    """

    def __init__(self, walk: mjbiped.Walk, step: int, face: float) -> None:
        begin = walk.touchdowns["time"][step - 1] if step else -1.0
        inside = (walk.samples["time"] > begin) & (walk.samples["time"] < walk.touchdowns["time"][step])
        self.time, self.q, self.dq, self.torque, stance, qpos = (
            walk.samples[name][inside] for name in ("time", "q", "dq", "torque", "stance", "qpos")
        )
        self.robot, length = walk.robot, walk.robot.leg_length
        swing = qpos[np.arange(len(qpos)), 3 - stance]
        self.x, self.z = qpos[:, 0] - length * np.sin(swing), qpos[:, 1] - length * np.cos(swing)
        self.jacobian = length * np.stack([np.cos(self.q[:, 0]), -np.cos(self.q[:, 1])], axis=1)  # dx/dq
        self.speed = (self.jacobian * self.dq).sum(axis=1)  # horizontal
        # on the face the horizontal speed is zero to rounding, off it it grows with 10 to 1000 m/s^2 or m/s^3
        on_face = (np.abs(self.x - face) < 1e-9) & (np.abs(self.speed) < 1e-13)
        assert on_face.any(), "no sample on the face: the face impact was not plastic"
        self.first, self.last = (int(row) for row in np.nonzero(on_face)[0][[0, -1]])
        assert on_face[self.first : self.last + 1].all()
        assert self.last - self.first > 1000

    def accelerations(self, row: int, *, on_face: bool) -> tuple[Array, float]:
        """Those of the legs by equation (1), and the force along x at the foot that holds it on the face."""
        q, dq, jacobian = self.q[row], self.dq[row], self.jacobian[row]
        pull = self.robot.input_matrix @ self.torque[row] - self.robot.gravity_vector(q, 0.0)
        pull -= self.robot.coriolis_matrix(q, dq) @ dq
        if not on_face:
            return np.linalg.solve(self.robot.mass_matrix(q), pull), 0.0
        bend = self.robot.leg_length * (math.sin(q[1]) * dq[1] ** 2 - math.sin(q[0]) * dq[0] ** 2)
        return self._held(q, jacobian, pull, -bend)

    def _held(self, q: Array, jacobian: Array, pull: Array, along: float) -> tuple[Array, float]:
        """Solve M a = pull + J f for a and f with J . a given."""
        whole = np.block([[self.robot.mass_matrix(q), -jacobian[:, None]], [jacobian[None, :], np.zeros((1, 1))]])
        solved = np.linalg.solve(whole, np.append(pull, along))
        return solved[:2], float(solved[2])

    def forces(self) -> Array:
        """The face's on the foot, along x, at the samples on it, N."""
        return np.array([self.accelerations(row, on_face=True)[1] for row in range(self.first, self.last + 1)])

    def check_face_impact(self, face: float) -> None:
        """The rates after it are those of a plastic impact without friction on a stance foot that stays."""
        before, after = self.first - 1, self.first
        ddq, _ = self.accelerations(before, on_face=False)
        late = (face - self.x[before]) / self.speed[before]  # up to 10 us; the foot's speed changes by 1e-4 m/s in it
        early = self.time[after] - self.time[before] - late
        q = self.q[before] + late * self.dq[before]
        jacobian = self.robot.leg_length * np.array([math.cos(q[0]), -math.cos(q[1])])
        struck, impulse = self._held(q, jacobian, self.robot.mass_matrix(q) @ (self.dq[before] + late * ddq), 0.0)
        assert impulse < -0.01  # N s: it pushes the foot back
        assert np.abs(struck - self.dq[before]).max() > 0.01
        found = self.dq[after] - early * self.accelerations(after, on_face=True)[0]
        # some 1e3 rad/s^3 over 10 us, twice: 1e-7; and the moment of the face impact to 1e-9 s
        assert found == pytest.approx(struck, abs=2e-7)


def test_foot_slides_over_the_top_edge_and_walks_on(controller: AdaptiveController) -> None:
    """The hip goes backwards at the start: only then a straight leg that is held at a face moves its foot upwards."""
    face, rise = 0.21, 0.009
    terrain = Terrain.from_segments([(face, 0.0), (9.0, 0.0, rise)])
    start = (0.11, 0.11, -0.36, -2.6)
    walk = mjbiped.walk(controller, terrain, engine="hybrid", steps=2, initial=start, sample_period=SAMPLE_PERIOD)
    foot = SwingFoot(walk, 0, face)
    foot.check_face_impact(face)
    first, last = foot.first, foot.last
    assert (foot.forces() < 0.0).all()  # pressed against the face up to the edge: it is the edge that ends the slide
    assert foot.z[first] < rise - 2e-3
    assert foot.z[last] <= rise <= foot.z[last + 1] + 1e-12
    # at the edge the force ends, and nothing jumps: rates taken there from both sides, 10 us apart at most
    held, _ = foot.accelerations(last, on_face=True)
    free, _ = foot.accelerations(last + 1, on_face=False)
    climb = (foot.z[last] - foot.z[last - 1]) / SAMPLE_PERIOD
    late = (rise - foot.z[last]) / climb
    assert np.abs(free - held).max() > 1.0
    assert foot.dq[last] + late * held == pytest.approx(foot.dq[last + 1] - (SAMPLE_PERIOD - late) * free, abs=2e-7)
    # pressed no more, it goes on forwards over the upper tread for a while (then the falling hip draws it back, above
    # the edge), and lands there
    assert (foot.x[last + 1 : last + 101] > face).all()
    assert (foot.z[last + 1 :] >= rise).all()
    assert walk.outcome == "finished"
    assert walk.touchdowns["strikes"].tolist() == [1, 0]
    assert walk.touchdowns["x"][0] > face + 0.1
    assert walk.touchdowns["z"][0] == pytest.approx(rise, abs=1e-12)


@pytest.mark.parametrize(("later", "locked"), [(1e-4, 1.0), (-1e-4, 0.0)])
def test_a_knee_strikes_in_the_step_in_which_the_hip_leaves_the_ground_if_it_comes_first(
    later: float, locked: float
) -> None:
    """The ground ends just after the place of the hip at the strike, or just before: within one integration step."""
    robot = mjbiped.KneedBiped()
    ground, gait = Terrain.incline(2.5), mjbiped.find_kneed_gait(robot, slope=math.radians(2.5))
    walk = mjbiped.walk(PassiveController(), ground, robot=robot, engine="hybrid", steps=1, sample_period=1e-4)
    assert walk.touchdowns["knee_strike"][0] == pytest.approx(gait.knee_strike, abs=1e-6)
    hip = float(np.interp(gait.knee_strike, walk.samples["time"], walk.samples["qpos"][:, 0]))
    short = dataclasses.replace(ground, end=hip + later)  # at some 1 m/s
    ended = mjbiped.walk(PassiveController(), short, robot=robot, engine="hybrid", steps=1)
    assert ended.outcome == "left the terrain"
    assert ended.end[0] == pytest.approx(gait.knee_strike, abs=2e-3)
    assert ended.samples["locked"][-1] == locked
