"""The hybrid engine with knees: passive walking against SciPy, the gait finder, energy, and the compass biped."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from rounding import assert_same
from scipy.integrate import solve_ivp
from simulations import Plain, hybrid_simulation

import mjbiped
from controllers import PassiveController
from mjbiped import KneedBiped, Terrain
from mjbiped.dynamics.modes import FREE, LOCKED, bend_stance_knee
from mjbiped.engines.hybrid.motion import enter_mode, rates
from mjbiped.engines.hybrid.resets import note_face, stop_swing_foot
from mjbiped.errors import InputError
from mjbiped.records import measures
from mjbiped.reports.repeat import command_of, python_of
from mjbiped.robots.bent_leg import bent_leg
from mjbiped.rules.termination import Outcome

Array = NDArray[np.float64]
ROBOT = KneedBiped()
SLOPE = math.radians(2.5)
START = (-0.24, 0.24, 0.24, 1.10, 0.33, 0.33)
"""Near the gait on 2.5 degrees, and not on it."""


def walked(start: Sequence[float], terrain: Terrain, **settings: Any) -> mjbiped.Walk:
    return mjbiped.walk(Plain(), terrain, robot=ROBOT, engine="hybrid", initial=start, **settings)


def phase(n: int, start: Array, end: Callable[[Array], float]) -> tuple[float, Array]:
    """Duration and end of a free motion of n segments on the slope, by SciPy and the robot's matrices."""

    def law(_: float, y: Array) -> Array:
        q, dq = y[:n], y[n:]
        pull = -ROBOT.coriolis_matrix(q, dq) @ dq - ROBOT.gravity_vector(q, SLOPE)
        return np.concatenate([dq, np.linalg.solve(ROBOT.mass_matrix(q), pull)])

    def event(t: float, y: Array) -> float:
        return end(y) if t > 0.05 else 1.0  # the knee has bent by then, and the foot is off the ground

    event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
    motion = solve_ivp(law, (0.0, 2.0), start, "DOP853", rtol=1e-13, atol=1e-14, events=event)
    return float(motion.t[-1]), motion.y[:, -1]


def test_state_after_a_passive_step() -> None:
    bent, struck = phase(3, np.array(START), lambda y: float(y[2] - y[1]))
    q, dq = ROBOT.knee_impact(struck[:3], struck[3:])
    straight, landed = phase(2, np.concatenate([q, dq]), lambda y: float(ROBOT.swing_foot(y[:2])[1]))
    after = np.concatenate(ROBOT.heel_impact(landed[:2], landed[2:]))[[0, 1, 1, 2, 3, 3]]
    touched = walked(START, Terrain.incline(2.5), steps=1).touchdowns
    # the issue's; measured 3e-11
    assert np.concatenate([touched["q"][0], touched["dq"][0]]) == pytest.approx(after, abs=1e-9)
    assert touched["time"][0] == pytest.approx(bent + straight, abs=1e-9)
    assert touched["knee_strike"][0] == pytest.approx(bent, abs=1e-9)
    assert touched["knee_q"][0] == pytest.approx(struck[:3], abs=1e-9)
    # rates of 4 rad/s, and accelerations of 1e2 rad/s^2 times the strike's 1e-11 s; measured 1.2e-9
    assert touched["knee_dq_before"][0] == pytest.approx(struck[3:], abs=4e-9)
    assert touched["knee_dq"][0] == pytest.approx(dq[[0, 1, 1]], abs=4e-9)


@pytest.fixture(scope="module")
def gait() -> mjbiped.KneedGait:
    return mjbiped.find_kneed_gait(ROBOT, SLOPE)


def test_thirty_steps_on_the_gait(gait: mjbiped.KneedGait, tmp_path: Any) -> None:
    """The issue's figures, of an earlier program; and the gait finder's, which integrates by itself."""
    walk = mjbiped.walk(Plain(), Terrain.incline(2.5), robot=ROBOT, engine="hybrid", steps=30)
    touched = walk.touchdowns
    assert (walk.outcome, walk.steps, walk.cost_of_transport) == ("finished", 30, 0.0)
    last = [0.24448, 1.08907, 0.35378, 0.61465, 0.52706]  # half angle, rates, period, knee strike
    period = measures.step_periods(walk)[-1]
    found = [touched["q"][-1, 1], *touched["dq"][-1, :2], period, touched["knee_strike"][-1]]
    assert found == pytest.approx(last, abs=0.6e-5)  # half a unit of the last digit
    state = np.concatenate([touched["q"], touched["dq"]], axis=1)
    assert np.abs(state - gait.start).max() < 2e-9  # tolerances of both integrations; measured 5e-10
    assert touched["flexion"] == pytest.approx(gait.greatest_flexion, abs=1e-6)  # its samples miss the top
    assert np.abs(measures.impact_errors(walk)).max() < 1e-14
    assert (touched["normal_force"] > 0.0).all()
    assert (touched["stubs"] == 0.0).all()
    # the foot is over the ground in all samples: none was passed through
    feet = ROBOT.limbs(walk.samples["qpos"])[:, :, -1]
    assert (feet[..., 1] - walk.terrain.height(feet[..., 0])).min() > -1e-12
    walk.save(tmp_path / "walk.npz")
    assert mjbiped.Walk.load(tmp_path / "walk.npz") == walk
    program = python_of(walk, "walk.npz")
    assert program is not None
    assert "scuffing=None" in program
    assert command_of(walk) is None  # of a class of these tests


def test_energy_is_conserved_between_impacts() -> None:
    samples = walked(START, Terrain.incline(2.5), steps=1, sample_period=1e-3).samples
    energy = np.array([ROBOT.energy(q, dq, SLOPE) for q, dq in zip(samples["q"], samples["dq"], strict=True)])[:-1]
    locked = samples["locked"][:-1].astype(bool)
    # dense output of order 7 at a step's tolerance of 1e-8, times dE/dy of some 1e2 J
    assert np.ptp(energy[~locked]) < 1e-6
    assert np.ptp(energy[locked]) < 1e-6
    assert energy[~locked].min() > energy[locked].max()  # the knee strike takes some


def test_contact_of_the_foot_can_wait_or_not(gait: mjbiped.KneedGait) -> None:
    """On from lift-off, or ignored for the first 1 or 5 % of each step: the same walk but for rounding."""
    walks = []
    for share in (0.0, 0.01, 0.05):
        simulation = hybrid_simulation(Terrain.incline(2.5), START, steps=3)
        if share:
            waits: dict[str, Any] = {"contact": False, "reach": -math.inf, "delay": share * gait.period}
            simulation.constants = replace(simulation.constants, **waits)
            simulation.state.contact_enabled = False
        simulation.go()
        assert simulation.outcome is Outcome.FINISHED
        walks.append(simulation.recorder.touchdowns())
    for later in walks[1:]:
        for name in ("time", "q", "dq", "knee_strike"):
            # other moments at which the step's events are looked for move them by rounding
            assert later[name] == pytest.approx(walks[0][name], abs=1e-12)


def test_locked_all_the_time_it_walks_as_the_compass() -> None:
    """Legs of halved rods with straight knees are Table I's, and scuff like them."""
    start = (-0.19, 0.19, 1.1, 0.81)
    compass = mjbiped.walk(
        PassiveController(), Terrain.incline(2.0), engine="hybrid", initial=start, steps=3, sample_period=None
    )
    rule = mjbiped.ScuffingRule()
    q1, q2, dq1, dq2 = start
    robot = KneedBiped.halved_rods()
    simulation = hybrid_simulation(Terrain.incline(2.0), (q1, q2, q2, dq1, dq2, dq2), robot=robot, steps=3)
    scuffs: dict[str, Any] = {"contact": False, "reach": rule.reach, "delay": rule.delay}
    simulation.constants = replace(simulation.constants, **scuffs)
    simulation.state.contact_enabled = False
    while simulation.ended is Outcome.WALKING:
        simulation.state.locked = LOCKED  # again after each touchdown
        enter_mode(simulation.constants, simulation.state)
        simulation.go_on()
        simulation.take()
    touched = simulation.recorder.touchdowns()
    for name in ("time", "x", "z", "friction", "normal_force"):
        assert touched[name] == pytest.approx(compass.touchdowns[name], abs=1e-9)  # the integrator's tolerance
    for name in ("q_before", "dq_before", "q", "dq"):
        assert touched[name][:, :2] == pytest.approx(compass.touchdowns[name], abs=1e-9)


NORMALS = [(-1.0, 0.0), (math.sin(0.03), math.cos(0.03))]
"""Of a riser ahead, and of ground on a slope."""


@pytest.mark.parametrize("normal", NORMALS)
def test_a_foot_that_strikes_is_stopped_along_the_normal(gait: mjbiped.KneedGait, normal: tuple[float, float]) -> None:
    """Newton's law with the robot's matrices: the impulse acts along the normal, and brings that speed to zero."""
    simulation = hybrid_simulation(Terrain.level(), gait.start.tolist())
    w, y = simulation.state, simulation.state.y
    for locked in (FREE, LOCKED):
        n = 3 if locked == FREE else 2
        before = [0.1, -0.2, -0.2 + 0.3 * (n == 3), 1.0, 2.0, 2.0 - 3.0 * (n == 3)]
        y[:6] = before
        w.locked, w.pushed_x, w.pushed_z = locked, *normal
        enter_mode(simulation.constants, w)
        stop_swing_foot(simulation.constants, w)
        q = np.array(before[:n])
        row = ROBOT.chains[n].reach * (np.cos(q) * normal[0] - np.sin(q) * normal[1])
        after = np.array(y[3 : 3 + n])
        impulse = ROBOT.mass_matrix(q) @ (after - before[3 : 3 + n])
        assert row @ after == pytest.approx(0.0, abs=1e-14)
        assert impulse == pytest.approx(row * (impulse @ row) / (row @ row), abs=1e-13)


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


def test_a_first_step_without_a_knee_strike_tells_of_none() -> None:
    simulation = hybrid_simulation(Terrain.level(), (-0.1, 0.1, 0.6, 1.2, 0.5, 0.0), steps=1)
    simulation.go()
    touched = simulation.recorder.touchdowns()
    for name in ("knee_strike", "knee_q", "knee_dq_before", "knee_dq"):
        assert np.isnan(touched[name]).all(), name


def test_the_ground_force_is_the_centre_of_masss(gait: mjbiped.KneedGait) -> None:
    """Least normal force of a step, again from second differences of the recorded places."""
    walk = walked(gait.start.tolist(), Terrain.incline(2.5), steps=1, sample_period=1e-4)
    samples = walk.samples
    centre = ROBOT.centre_of_mass(samples["qpos"])
    smooth = samples["locked"][2:] == samples["locked"][:-2]
    force = ROBOT.total_mass * (np.diff(centre, 2, axis=0)[smooth] / 1e-8 + [0.0, ROBOT.gravity])
    normal = force @ [math.sin(SLOPE), math.cos(SLOPE)]
    # fourth derivatives of 1e3 m/s^4 times h^2 / 12, rounding of 1e-16 / h^2, and the last sample of another stance
    assert walk.touchdowns["normal_force"][0] == pytest.approx(np.sort(normal[:-2])[0], abs=2e-3 * ROBOT.weight)


def test_starts_and_controllers_that_do_not_fit_are_refused() -> None:
    with pytest.raises(InputError, match="bent forwards"):
        walked((-0.2, 0.2, 0.1, 1.0, 0.5, 0.5), Terrain.incline(2.5))
    with pytest.raises(InputError, match="six finite numbers"):
        walked((-0.2, 0.2, 1.0, 0.5), Terrain.incline(2.5))
    with pytest.raises(InputError, match="swing foot would start"):
        walked((-0.2, 0.1, 0.1, 1.0, 0.5, 0.5), Terrain.incline(2.5))
    with pytest.raises(InputError, match="contact is on from lift-off"):
        walked(START, Terrain.incline(2.5), scuffing=mjbiped.ScuffingRule(reach=0.1))


def test_a_heavier_hip_walks_too() -> None:
    """Another robot than the defaults, on a slope of its own, by its own gait."""
    robot = replace(ROBOT, hip_mass=7.0)
    walk = mjbiped.walk(Plain(), Terrain.incline(3.0), robot=robot, engine="hybrid", steps=3)
    assert (walk.outcome, walk.robot) == ("finished", robot)


@pytest.mark.slow
def test_compiled_walks_are_those_of_plain_python(gait: mjbiped.KneedGait) -> None:
    plain = mjbiped.walk(Plain(), Terrain.incline(2.5), robot=ROBOT, engine="hybrid", steps=20)
    fast = mjbiped.walk(PassiveController(), Terrain.incline(2.5), robot=ROBOT, engine="hybrid", steps=20)
    for name in ("time", "q", "dq", "normal_force", "knee_strike"):
        # products and sums in one rounding, over 20 steps of a gait that forgets
        assert_same(fast.touchdowns[name], plain.touchdowns[name], 1e-10, name)
    assert fast == mjbiped.walk(PassiveController(), Terrain.incline(2.5), robot=ROBOT, engine="hybrid", steps=20)


def test_energy_is_conserved_over_a_leg_that_stands_bent() -> None:
    """That of the chain of four segments; the lock of a knee does no work."""
    flexion = 0.4
    simulation = hybrid_simulation(Terrain.level(), (-0.1, 0.1, 0.6, 1.2, 0.5, 0.0), sample_period=1e-3)
    c, w = simulation.constants, simulation.state
    w.stance_flexion = flexion
    bend_stance_knee(w, c.upper, c.lower, flexion)
    enter_mode(c, w)
    simulation.go()
    samples = simulation.recorder.samples()
    free = ~samples["locked"].astype(bool) & (samples["time"] < 0.2)
    assert np.count_nonzero(free) > 100
    _, lean = bent_leg(ROBOT.thigh_length, ROBOT.shank_length, flexion)
    energies = []
    for q, dq in zip(samples["q"][free], samples["dq"][free], strict=True):
        four = np.array([q[0] + lean, q[0] + lean - flexion, q[1], q[2]])
        energies.append(ROBOT.energy(four, dq[[0, 0, 1, 2]], 0.0))
    assert np.ptp(energies) < 1e-6  # as above
    np.testing.assert_array_equal(samples["qpos"][free][:, 4], flexion)


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
