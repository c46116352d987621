"""The biped with knees on round feet: what it is made of, what it refuses, its points, its walks in both engines."""

import math
from typing import Any

import mujoco
import numpy as np
import pytest

import mjbiped
from mjbiped.controllers import KneedController, PassiveController
from mjbiped.dynamics.linkage import Motion, room
from mjbiped.dynamics.modes import land
from mjbiped.errors import InputError
from mjbiped.robots.chain import Array
from mjbiped.robots.kinds import robot_from
from mjbiped.robots.kneed import KneedBiped, stance_knee_torque
from mjbiped.robots.round import RoundKneed

SLOPE = 0.0456
PLAIN = KneedBiped()
POINT = RoundKneed(
    **{name: getattr(PLAIN, name) for name in KneedBiped.numbers()}, foot_radius=0.0, stop_angle=0.0, shank_offset=0.0
)
"""`KneedBiped()` by the equations of round feet."""


class Called(PassiveController):
    """No torque, by the engines' plain Python."""

    def law(self) -> Any:
        """None: nothing is compiled."""
        return None


def test_a_description_is_read_back() -> None:
    robot = RoundKneed(hip_mass=2.0, foot_radius=0.3, shank_mass=2.0, shank_length=0.6)
    assert robot_from(robot.to_dict()) == robot
    assert robot.shank_inertia == pytest.approx(2.0 * (0.186 * 0.6 / 0.54) ** 2)


def test_the_centre_of_the_arc_is_on_the_shank() -> None:
    with pytest.raises(InputError, match=r"foot_radius = 0.54: must be less than shank_length = 0.54 m"):
        RoundKneed(foot_radius=0.54)
    with pytest.raises(InputError, match=r"thigh_centre = 0.5: must lie on the link"):
        RoundKneed(thigh_centre=0.5)


@pytest.mark.slow
def test_what_is_for_point_feet_is_refused() -> None:
    with pytest.raises(InputError, match="a RoundKneed rolls"):
        _ = RoundKneed().model
    with pytest.raises(InputError, match="a RoundKneed walks on planes"):
        mjbiped.walk(PassiveController(), mjbiped.Terrain.stairs(tread=1.0, rise=0.01), robot=RoundKneed(), steps=1)
    with pytest.raises(InputError, match=r"needs a mjbiped.KneedBiped"):
        KneedController(RoundKneed(), mjbiped.find_kneed_gait(RoundKneed(), SLOPE))  # type: ignore[arg-type]
    engine = mjbiped.Mujoco(stance_knee="motor")
    with pytest.raises(InputError, match="the stop of a RoundKneed bears its stance knee"):
        mjbiped.walk(PassiveController(), mjbiped.Terrain.incline(2.6), robot=RoundKneed(), engine=engine, steps=1)


def _row(numbers: Any) -> Array:
    """Numbers, or arrays of any shapes, one after the other."""
    parts = numbers if isinstance(numbers, tuple) else (numbers,)
    return np.concatenate([np.ravel(part) for part in parts])


def test_feet_of_no_radius_are_points() -> None:
    """All equations are those of `KneedBiped`, but for the departing knee, which that one keeps locked."""
    q, dq, torque = np.array([0.3, -0.2, 0.4]), np.array([1.0, 0.5, -2.0]), (3.0, -2.0, 1.0)
    straight = q[[0, 1, 1]]
    for name, given in (
        ("mass_matrix", (q,)),
        ("coriolis_matrix", (q, dq)),
        ("gravity_vector", (q, 0.1)),
        ("mass_matrix", (q[:2],)),
        ("gravity_vector", (q[:2], 0.1)),
        ("energy", (q, dq, 0.1)),
        ("swing_foot", (q,)),
        ("knee_impact", (straight, dq)),
        ("posture", ((0.1, 0.2), 1, q)),
        ("limbs", ([0.1, 0.9, 0.2, -0.1, 0.0, 0.5],)),
        ("centre_of_mass", ([0.1, 0.9, 0.2, -0.1, 0.0, 0.5],)),
        ("ground_force", (q, dq, torque, 0.1)),
    ):
        np.testing.assert_allclose(
            _row(getattr(POINT, name)(*given)), _row(getattr(PLAIN, name)(*given)), rtol=1e-12, atol=1e-12
        )
    for locked in (False, True):
        mine, its = (robot.ground_force(q, dq, torque, 0.1, locked=locked) for robot in (POINT, PLAIN))
        np.testing.assert_allclose(mine, its, rtol=1e-12, atol=1e-12)
        held = [float(stance_knee_torque(robot, q, dq, torque, 0.1, locked=locked)) for robot in (POINT, PLAIN)]
        assert held[0] == pytest.approx(held[1], rel=1e-12, abs=1e-12)
    motion = Motion(**room())
    linkage = POINT.linkages[0]
    land(linkage, linkage, motion, [*q[[0, 1, 1]], *dq[[0, 1, 1]]], True)  # both legs of one piece
    np.testing.assert_allclose(motion.right[:2], PLAIN.heel_impact(q[:2], dq[:2])[1], rtol=1e-12, atol=1e-12)


def test_a_straight_leg_of_the_stop_is_that_of_the_equations() -> None:
    """From the drawn points: hip over the arc's centre, both centres level while the legs' angles are opposite."""
    robot = RoundKneed()
    qpos = [0.0, 1.0, -0.3, 0.3, 0.0, 0.0]
    lines, limbs = robot.outline(qpos), robot.limbs(qpos)
    shank = (limbs[:, 2] - limbs[:, 1]) / robot.shank_length
    centres = limbs[:, 2] - robot.foot_radius * shank
    length = robot.leg_length - robot.foot_radius
    wanted = np.array([[length * math.sin(0.3), 1.0 - length * math.cos(0.3)]]) * [[1.0, 1.0], [-1.0, 1.0]]
    np.testing.assert_allclose(centres, wanted, atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(lines[:, 3:] - centres[:, None], axis=-1), robot.foot_radius, rtol=1e-12)
    bend = np.arctan2(*(limbs[:, 1] - limbs[:, 2]).T) - np.arctan2(*(limbs[:, 0] - limbs[:, 1]).T)
    np.testing.assert_allclose(bend, -robot.stop_angle, atol=1e-15)  # the shank is ahead


def test_states_after_a_touchdown_are_those_that_a_heel_strike_leaves() -> None:
    """With a knee that opens, and with one that the stop holds."""
    robot, opened = RoundKneed(), []
    for stance, swing in ((1.2, 0.4), (1.0, 2.5), (-1.0, 2.0)):
        q, dq = robot.heel_impact([0.3, -0.3], [stance, swing])
        state = np.concatenate([q, dq])
        np.testing.assert_allclose(robot.after_touchdown(state[[0, 3, 4]]), state, rtol=0, atol=1e-13)
        opened.append(bool(dq[2] > dq[1]))
    assert set(opened) == {False, True}


def test_mujocos_bodies_are_the_robots() -> None:
    """Places of arcs, knees and masses, and the energy of the motion; all numbers of models are doubles."""
    robot, q, dq = RoundKneed(), np.array([-0.3, 0.2, 0.9]), np.array([1.0, -0.5, 2.0])
    made = mjbiped.Mujoco().simulation(
        Called(), mjbiped.Terrain.level(), robot=robot, initial=(*q, *dq), steps=1, compile=False
    )
    model, data = made.model, made.data
    mujoco.mj_fwdPosition(model, data)
    qpos = np.array([data.joint(name).qpos[0] for name in robot.places])
    lines = robot.limbs(qpos)
    for side, line in zip(("left", "right"), lines, strict=True):
        down = (line[2] - line[1]) / robot.shank_length
        np.testing.assert_allclose(
            data.geom(f"{side}_foot").xpos[[0, 2]], line[2] - robot.foot_radius * down, atol=1e-12
        )
        np.testing.assert_allclose(data.body(f"{side}_shank").xpos[[0, 2]], line[1], atol=1e-12)
    # the hip has a share of 1e-9 of the mass at least, and MuJoCo's inertias have no smaller ones
    np.testing.assert_allclose(data.subtree_com[0][[0, 2]], robot.centre_of_mass(qpos), atol=1e-8)
    mujoco.mj_energyVel(model, data)
    assert data.energy[1] == pytest.approx(robot.kinetic_energy(q, dq), rel=1e-8)


def steps_of(engine: mjbiped.Hybrid | mjbiped.Mujoco, controller: PassiveController, steps: int) -> mjbiped.Walk:
    ground = mjbiped.Terrain.incline(math.degrees(SLOPE))
    return mjbiped.walk(controller, ground, robot=RoundKneed(), engine=engine, steps=steps)


def test_the_hybrid_engine_repeats_the_passive_gait() -> None:
    """Its greatest multiplier is 0.46, so that errors of the steps do not add up."""
    gait = mjbiped.find_kneed_gait(RoundKneed(), SLOPE)
    walk = steps_of(mjbiped.Hybrid(), Called(), 3)
    touchdowns = walk.touchdowns
    np.testing.assert_allclose(touchdowns["q"], np.tile(gait.start[:3], (3, 1)), atol=1e-8)
    np.testing.assert_allclose(touchdowns["dq"], np.tile(gait.start[3:], (3, 1)), atol=1e-7)
    np.testing.assert_allclose(touchdowns["knee_strike"], gait.knee_strike, atol=1e-8)
    along = np.hypot(np.diff(touchdowns["x"]), np.diff(touchdowns["z"]))
    np.testing.assert_allclose(along, gait.step_length, rtol=1e-8)
    assert touchdowns["z"] == pytest.approx(-np.tan(SLOPE) * touchdowns["x"], abs=1e-9)
    # the load presses the stance knee on its stop all the way, as McGeer wants it: the stop needs no lock
    samples = walk.samples
    state = (samples[name] for name in ("q", "dq", "torque", "slope"))
    assert stance_knee_torque(RoundKneed(), *state, locked=samples["locked"]).max() < -0.4


def test_a_foot_that_comes_down_on_a_bent_knee_trips_the_robot() -> None:
    gait = mjbiped.find_kneed_gait(RoundKneed(), SLOPE)
    late = gait.start * [1.0, 1.0, 1.0, 1.6, 1.0, 1.0]
    ground = mjbiped.Terrain.incline(math.degrees(SLOPE))
    walk = mjbiped.walk(Called(), ground, robot=RoundKneed(), engine="hybrid", steps=3, initial=late)
    assert (walk.outcome, walk.steps) == ("fell", 0)


@pytest.mark.slow
def test_mujoco_rolls_and_bends_as_the_hybrid_engine_does() -> None:
    """Nothing of the impact maps or of rolling is in MuJoCo but spheres, friction and stops.

    The rates after a touchdown differ by 4e-4 rad/s: the departing leg's knee, which opens in the contact step.
    """
    hybrid, rolled = (
        steps_of(engine, PassiveController(), 4).touchdowns for engine in (mjbiped.Hybrid(), mjbiped.Mujoco())
    )
    np.testing.assert_allclose(rolled["q"], hybrid["q"], atol=1e-4)
    np.testing.assert_allclose(rolled["dq"], hybrid["dq"], atol=2e-3)
    np.testing.assert_allclose(rolled["x"], hybrid["x"], atol=1e-4)
    np.testing.assert_allclose(rolled["knee_strike"], hybrid["knee_strike"], atol=1e-4)
    assert rolled["slip"].max() < 1e-5
    assert not rolled["stubs"].any()
