"""Steps that land on the touchdown: where they end, how long they are, and what that does to impacts and walks."""

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from simulations import Plain, started

import mjbiped
from controllers import AdaptiveController, Controller, Memory, PassiveController
from mjbiped.engines.mujoco import observation, softness, step_size
from mjbiped.engines.mujoco.contacts import Felt
from mjbiped.engines.mujoco.leapfrog import effective_step
from mjbiped.engines.mujoco.legs import stance_leg, swing_leg
from mjbiped.engines.mujoco.lifting import SHORTEST
from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.engines.mujoco.state import State
from mjbiped.records import measures

Terrain = mjbiped.Terrain
AWAY = Felt(0.0, 0.0, 0.0, 0.0, False, False)
GROUNDS = {
    "level": Terrain.level(),
    "down 3": Terrain.incline(3.0),
    "up 3": Terrain.incline(-3.0),
    "slopes": Terrain.slopes(change_deg=-1.0),
    "stairs -0.06": Terrain.stairs(rise=-0.06),
    "stairs +0.006": Terrain.stairs(rise=0.006),
    "mixed": Terrain.mixed(),
    **{f"random {seed}": Terrain.random(seed=seed) for seed in (3, 5)},
}


@pytest.mark.parametrize("timestep", [2e-4, 2e-3])
@pytest.mark.parametrize("name", ["level", "mixed", "stairs -0.06", "random 3"])
def test_a_step_ends_where_the_foot_meets_the_ground(
    name: str, timestep: float, controller: AdaptiveController
) -> None:
    """An Euler step is known before it is made. The contact step that follows is as long as it should be."""
    terrain = GROUNDS[name]
    simulation = started(controller, terrain, steps=6, timestep=timestep)
    data, u, length = simulation.data, simulation.state, simulation.constants.leg_length
    heights, lengths = [], []
    while not u.outcome:
        swing = data.qpos[3 if u.stance == 0 else 2]
        x, z = data.qpos[0] - length * math.sin(swing), data.qpos[1] - length * math.cos(swing)
        simulation.advance(1)
        lengths.append(simulation.model.opt.timestep)
        if u.noted:
            heights.append(z - terrain.height_at(x))
            assert (lengths[-1], u.effective_step, u.plain) == (1e-5, 1e-5, 1.0)
    assert len(heights) == 6
    # no step is shorter than 1e-9 s, in which the foot falls by 3e-9 m at most
    assert heights == pytest.approx([-step_size.DEPTH] * 6, abs=3e-9)
    assert max(lengths) == timestep
    assert min(lengths) > 0.0


@pytest.mark.parametrize("timestep", [1e-3, 4e-3])
@pytest.mark.parametrize("name", GROUNDS)
def test_every_impact_is_the_impact_map(name: str, timestep: float, controller: AdaptiveController) -> None:
    walk = mjbiped.walk(controller, GROUNDS[name], steps=12, engine=mjbiped.Mujoco(timestep=timestep))
    assert walk.outcome == "finished"
    # 1e-5 s of motion at up to 30 rad/s², of some 0.8 rad/s; measured 2e-4
    errors = np.abs(measures.impact_errors(walk))
    assert errors.max() < 5e-4
    assert np.median(errors) < 3e-4


def test_half_a_kick_after_the_impact(controller: AdaptiveController) -> None:
    """Without it rates are off by half a step's acceleration at either end: c_mt by 1.3 % at 1 ms, here as measured."""
    level = Terrain.level()
    exact = mjbiped.walk(controller, level, steps=12, engine="hybrid").cost_of_transport
    errors = [
        mjbiped.walk(controller, level, steps=12, engine=mjbiped.Mujoco(timestep=timestep)).cost_of_transport / exact
        - 1.0
        for timestep in (1e-3, 2e-3)
    ]
    # measured 3e-5 and 6e-6, of the contact step and the foot's rolling
    assert np.abs(errors).max() < 2e-4


def test_passive_step_length_at_long_steps(gait: mjbiped.Gait) -> None:
    walk = mjbiped.walk(PassiveController(), Terrain.incline(2.0), steps=12, engine=mjbiped.Mujoco(timestep=2e-3))
    # the foot's rolling is 5e-5; 6e-3 without half effective steps
    assert measures.step_lengths(walk)[-6:].mean() == pytest.approx(gait.step_length, rel=3e-4)


class Asked(Controller):
    """The torque of another controller, and when it was asked for."""

    states = AdaptiveController.states
    memory_size = AdaptiveController.memory_size

    def __init__(self, controller: AdaptiveController) -> None:
        self.law_of, self.times = controller, [0.0]

    def start(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        self.law_of.start(memory, q, dq)

    def on_touchdown(self, memory: Memory, q_before: Sequence[float], q: Sequence[float], dq: Sequence[float]) -> None:
        self.law_of.on_touchdown(memory, q_before, q, dq)

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        self.times.append(t)
        return self.law_of.torque(memory, t, q, dq)


def test_a_slow_controller_keeps_its_beat(controller: AdaptiveController) -> None:
    """Steps land between its ticks, which stay where they are; only a contact step makes one wait."""
    slow = Asked(controller)
    q1, q2, dq1, dq2 = controller.gait.start.tolist()
    engine = mjbiped.Mujoco(control_period=5e-3, timestep=1e-3)
    walk = mjbiped.walk(slow, Terrain.slopes(), steps=3, initial=(q1, q2, dq1, dq2), engine=engine)
    since = np.array(slow.times[1:])
    exchanges = np.concatenate([[0.0], walk.touchdowns["time"]])
    step = np.concatenate([[0], np.cumsum(np.diff(since) < 0.0)])
    late = np.mod(since + exchanges[step] + 1e-9, 5e-3)[:-1]  # the last tick tells the last touchdown
    assert late.max() < 2e-5 + 2e-9
    assert walk.outcome == "finished"


@pytest.mark.slow
def test_struck_faces_at_long_steps(controller: AdaptiveController) -> None:
    """Near a riser steps are short: a foot neither tunnels through a plate of 2 mm nor is thrown off by it."""
    terrain = Terrain.stairs(rise=0.045, first=1.0, count=1)
    fine, coarse = (mjbiped.walk(controller, terrain, steps=3, engine=mjbiped.Mujoco(timestep=h)) for h in (2e-4, 2e-3))
    assert fine.touchdowns["strikes"].tolist() == coarse.touchdowns["strikes"].tolist() == [0, 0, 1]
    # a face impact's own error is some mm in either (docs/physics.md)
    assert coarse.touchdowns["x"] == pytest.approx(fine.touchdowns["x"], abs=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("after", [9e-4, 1.5e-3, 2.1e-3])
def test_a_face_right_where_the_foot_begins_to_collide(after: float, controller: AdaptiveController) -> None:
    """The foot comes 1.5 mm further in a step: it is let collide after its first of these ways, and met the face in the
    next one, which was damped for a contact step but counted for half a long one: it was thrown back at 40 m/s.
    """
    gait = controller.gait
    terrain = Terrain.stairs(tread=100.0, rise=0.03, first=gait.step_length + 0.2 + after, count=1)
    walks = [mjbiped.walk(controller, terrain, steps=4, engine=engine) for engine in ("mujoco", "hybrid")]
    assert [walk.outcome for walk in walks] == ["finished", "finished"]
    assert [walk.touchdowns["strikes"][1] for walk in walks] == [1, 1]
    # the slip of the stance foot, which the hybrid engine's has not, is some mm
    assert walks[0].touchdowns["x"] == pytest.approx(walks[1].touchdowns["x"], abs=0.01)


def test_steps_of_one_length(controller: AdaptiveController) -> None:
    """Without landing the model stays as it is."""
    simulation = started(controller, Terrain.mixed(), timestep=2e-4, lands=False)
    softness = simulation.model.geom_solref.copy()
    assert simulation.advance(9000) == 9000
    assert simulation.state.count == 2
    assert simulation.data.time == pytest.approx(9000 * 2e-4, rel=1e-9)
    assert np.array_equal(simulation.model.geom_solref, softness)


def flown(
    simulation: Simulation,
    place: tuple[float, float],
    speed: tuple[float, float],
    until: Callable[[float, float], bool],
) -> tuple[list[float], list[tuple[float, float]], State]:
    """Lengths of the steps of a swing foot that flies on a parabola, the places that they lead to, and the state."""
    constants, u = simulation.constants, State()
    u.planned = u.last_step = constants.longest
    u.enabled, u.next_control = 1.0, math.inf
    leg, angle = constants.leg_length, -0.2
    u.q[:4] = *np.add(place, [leg * math.sin(angle), leg * math.cos(angle)]), 0.0, angle
    u.qvel[:2], u.qacc[:2] = speed, (0.5, -9.81)
    lengths: list[float] = []
    places = [place]
    while not until(*places[-1]):
        found = step_size.step_lengths(constants, u, AWAY, 1.0)
        lengths.append(found.length)
        for index in range(2):
            u.qvel[index] += effective_step(u.plain, u.last_step, found.length) * u.qacc[index]
            u.q[index] += found.length * u.qvel[index]
        places.append((u.q[0] - leg * math.sin(angle), u.q[1] - leg * math.cos(angle)))
        u.time += found.length
        u.planned, u.plain, u.last_step = found.following, float(found.reached), found.length
    return lengths, places, u


@pytest.mark.parametrize("timestep", [2e-4, 4e-3])
def test_steps_become_shorter_and_the_last_one_lands(timestep: float, controller: AdaptiveController) -> None:
    ground = Terrain.incline(3.0)
    simulation = started(controller, ground, timestep=timestep)
    for height, falling in ((0.02, 0.5), (0.003, 1.5)):
        start = (0.3, ground.height_at(0.3) + height)
        lengths, places, u = flown(simulation, start, (0.8, -falling), lambda x, z: z < ground.height_at(x))
        x, z = places[-1]
        assert ground.height_at(x) - z == pytest.approx(step_size.DEPTH, abs=1e-12)
        assert (u.planned, u.plain) == (1e-5, 1.0)
        # the approach began in time, so that the last step is as long as planned, but for the shortest step there is
        assert lengths[-1] == pytest.approx(1e-5, abs=2.0 * SHORTEST)
        assert max(lengths) <= timestep
        shortened = sum(length < timestep for length in lengths)
        assert shortened < 2 * math.log(timestep / 1e-5, step_size.SHORTER) + 4  # few: the approach, and what rounds


@pytest.mark.parametrize(("height", "short"), [(0.01, True), (0.0305, True), (0.04, False)])
def test_near_a_face_all_steps_are_contact_steps(height: float, short: bool, controller: AdaptiveController) -> None:
    """Of a foot that comes to 1 mm ahead of it in the next two steps, or lies beside it, not far over its top."""
    face = 1.0
    simulation = started(controller, Terrain.stairs(tread=100.0, rise=0.03, first=face, count=1), timestep=1e-3)
    lengths, places, _ = flown(simulation, (0.98, height), (1.0, 0.15), lambda x, _: x > face - 1e-3)
    # from 1 mm and two steps of 1 ms on, at 1.00 to 1.01 m/s
    near = [length for length, (x, _) in zip(lengths, places, strict=False) if x > face - 3.00e-3]
    far = [length for length, (x, _) in zip(lengths, places, strict=False) if x < face - 3.03e-3]
    assert set(far) == {1e-3}
    assert set(near) == ({1e-5} if short else {1e-3})


def test_a_step_ends_at_the_tick_but_for_an_impact(controller: AdaptiveController) -> None:
    simulation = started(controller, Terrain.level(), timestep=1e-3, control_period=5e-3)
    for noted in (0.0, 1.0):
        u = State()
        u.time, u.planned, u.next_control, u.noted, u.q[1] = 0.2, 1e-3, 0.2004, noted, 1.2
        found = step_size.step_lengths(simulation.constants, u, AWAY, 1.0)
        assert found.length == pytest.approx(1e-3 if noted else 4e-4, abs=1e-12)
        assert found.following == 1e-3
        u.next_control = 0.2011
        assert step_size.step_lengths(simulation.constants, u, AWAY, 1.0).length == 1e-3


@pytest.mark.parametrize(
    ("x", "z", "low", "high", "there"),
    [
        (0.95, 0.0, 0.9, 1.1, True),  # up a riser ahead
        (0.95, 0.0309, 0.9, 1.1, True),
        (0.95, 0.0311, 0.9, 1.1, False),  # over its top
        (0.95, 0.0, 0.9, 0.99, False),  # not reached
        (0.95, 0.0, 1.01, 1.1, False),
        (1.05, 0.0, 0.9, 1.1, True),  # behind
        (2.05, 0.0, 1.9, 2.1, True),  # behind, the foot having stepped down from it
        (2.05, 0.0311, 1.9, 2.1, False),
        (1.95, 0.0309, 1.9, 2.1, True),
        (2.95, -0.1, 2.9, 3.1, False),  # a change of slope is no face
    ],
)
def test_where_a_face_is_met(
    x: float, z: float, low: float, high: float, there: bool, controller: AdaptiveController
) -> None:
    ground = Terrain((-5.0, 1.0, 2.0, 3.0), (0.0, 0.03, 0.0, 0.0), (0.0, 0.0, 0.0, 0.1))
    c = started(controller, ground, timestep=1e-3).constants
    assert step_size.face_between(c, x, z, low, high, 1e-3) == there


@pytest.mark.parametrize("locked", [0.0, 1.0])
@pytest.mark.parametrize("strikes", [0.0, 1.0])
def test_a_swing_knee_is_locked_where_it_is_or_is_about_to_strike(locked: float, strikes: float) -> None:
    """In the step after the one that leads it to its stop."""
    simulation = started(Plain(), Terrain.level(), robot=mjbiped.KneedBiped())
    c, u = simulation.constants, simulation.state
    u.locked, u.strikes_next = locked, strikes
    observation.observe(c, u, 0.1)
    softness.soften(c, u)
    held = simulation.data.eq_active
    assert held[swing_leg(c, u).lock] == max(locked, strikes)
    assert held[stance_leg(c, u).lock] == 1
