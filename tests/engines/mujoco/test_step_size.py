"""Steps that land on the touchdown: where they end, how long they are, and what that does to impacts and walks."""

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from simulations import started

import mjbiped
from controllers import AdaptiveController, Controller, Memory
from mjbiped.engines.mujoco import step_size
from mjbiped.engines.mujoco.feet import Felt
from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.engines.mujoco.state import State, effective_step

Terrain = mjbiped.Terrain
AWAY = Felt(0.0, 0.0, 0.0, 0.0, False, False)


@pytest.mark.parametrize(
    ("terrain", "timestep"),
    [(Terrain.stairs(rise=-0.06), 2e-4), (Terrain.random(seed=3), 2e-3)],
    ids=["stairs", "random"],
)
def test_a_step_ends_where_the_foot_meets_the_ground(
    terrain: Terrain, timestep: float, controller: AdaptiveController
) -> None:
    """An Euler step is known before it is made. The contact step that follows is as long as it should be."""
    simulation = started(controller, terrain, steps=4, timestep=timestep)
    data, u, length = simulation.data, simulation.state, simulation.constants.leg_length
    heights, lengths = [], []
    while not u.outcome:
        swing = data.qpos[3 if u.stance == 0 else 2]
        x, z = data.qpos[0] - length * math.sin(swing), data.qpos[1] - length * math.cos(swing)
        plain = u.plain
        simulation.advance(1)
        lengths.append(simulation.model.opt.timestep)
        if u.noted:
            heights.append(z - terrain.height_at(x))
            assert (lengths[-1], u.effective_step, plain) == (1e-5, 1e-5, 1.0)
    assert len(heights) == 4
    # no step is shorter than 1e-9 s, in which the foot falls by 3e-9 m at most
    assert heights == pytest.approx([-step_size.DEPTH] * 4, abs=3e-9)
    assert max(lengths) == timestep
    assert min(lengths) > 0.0


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
            u.qvel[index] += effective_step(u, found.length) * u.qacc[index]
            u.q[index] += found.length * u.qvel[index]
        places.append((u.q[0] - leg * math.sin(angle), u.q[1] - leg * math.cos(angle)))
        u.time += found.length
        u.planned, u.plain, u.last_step = found.following, float(found.reached), found.length
    return lengths, places, u


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
