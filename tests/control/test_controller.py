"""What every controller offers, the passive one, and one that a user writes."""

import dataclasses
import json
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mjbiped
from controllers import AdaptiveController, Controller, Memory, PassiveController
from mjbiped.control.compiled import compilable_law
from mjbiped.control.controller import ROOM, Unpowered
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.passive import find_passive_gait
from mjbiped.robots.compass import Array, Compass
from mjbiped.robots.robot import Robot

TABLE_ONE = Compass()


@pytest.fixture(scope="module")
def gait() -> Gait:
    return find_passive_gait(TABLE_ONE, math.radians(2))


class HipSpring(Controller):
    """A user's own: a plain class with one method."""

    stiffness = 20.0

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        del memory, t, dq
        return 0.0, -self.stiffness * (q[1] - q[0])


class Counter(Controller):
    """A user's own with a state that the engine integrates and a number that changes at touchdown."""

    states = ("impulse",)
    memory_size = 2

    def on_touchdown(self, memory: Memory, q_before: Sequence[float], q: Sequence[float], dq: Sequence[float]) -> None:
        del q_before, q, dq
        memory[1] += 1.0

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        del t, q, dq
        ankle = 0.1 * memory[1]
        return ankle, 0.0, ankle


@dataclasses.dataclass(frozen=True)
class Everything(Controller):
    """Parameters of every kind, for the record."""

    robot: Compass
    gait: Gait
    gain: float = 1.5
    count: int = 3
    switch: bool = True
    word: str = "x"
    nothing: None = None
    table: Any = dataclasses.field(default_factory=lambda: np.arange(3.0))

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        del memory, t, q, dq
        return 0.0, 0.0


def motion(controller: Controller, memory: list[float], slope: float) -> Any:
    """Right-hand side of eq. (1) under a controller without integrated states."""
    robot = TABLE_ONE

    def rates(t: float, y: Array) -> Array:
        q, dq = y[:2], y[2:4]
        tau = np.array(controller.torque(memory, t, q.tolist(), dq.tolist()))
        force = robot.input_matrix @ tau - robot.coriolis_matrix(q, dq) @ dq - robot.gravity_vector(q, slope)
        return np.concatenate([dq, np.linalg.solve(robot.mass_matrix(q), force)])

    return rates


def test_a_controller_without_a_law_cannot_be_made() -> None:
    with pytest.raises(TypeError, match="torque"):
        Controller()  # type: ignore[abstract]  # that is the point


def test_a_law_is_all_that_a_controller_needs() -> None:
    spring = HipSpring()
    assert (spring.states, spring.memory_size, spring.robot, spring.gait) == ((), 0, None, None)
    memory: list[float] = []
    spring.start(memory, (0.1, -0.1), (0.0, 0.0))
    spring.on_touchdown(memory, (0.2, -0.2), (-0.2, 0.2), (1.0, 1.0))
    assert memory == []
    assert math.isnan(spring.slope_estimate(memory))
    assert spring.describe() == {"name": "HipSpring"}


def test_a_hip_spring_stores_what_it_takes(gait: Gait) -> None:
    """Energy of robot and spring is constant: the hip torque acts between the legs and does the work it should."""
    spring, slope = HipSpring(), gait.slope

    def energy(y: Array) -> float:
        return TABLE_ONE.energy(y[:2], y[2:], slope) + 0.5 * spring.stiffness * float(y[1] - y[0]) ** 2

    solution = solve_ivp(motion(spring, [], slope), (0.0, 0.7), gait.start, "DOP853", rtol=1e-10, atol=1e-12)
    energies = [energy(y) for y in solution.y.T]
    # 20 to 30 steps of 1e-10 on rates of order 1, times masses and torques of order 10
    np.testing.assert_allclose(energies, energies[0], rtol=0, atol=1e-7)
    spread = solution.y[1] - solution.y[0]
    assert np.ptp(0.5 * spring.stiffness * spread**2) > 1.0  # the spring did take part, with more than a joule


def test_a_users_memory_is_integrated_and_changed_at_touchdown() -> None:
    counter, memory = Counter(), [0.0, 0.0]
    counter.start(memory, (0.0, 0.0), (0.0, 0.0))
    for _ in range(3):
        counter.on_touchdown(memory, (0.0, 0.0), (0.0, 0.0), (0.0, 0.0))
    torque = counter.torque(memory, 0.0, (0.0, 0.0), (0.0, 0.0))
    assert memory == [0.0, 3.0]
    assert len(torque) == 2 + len(counter.states)
    assert torque[2] == torque[0] == pytest.approx(0.3)  # pytest's 1e-6: the number is 3 times 0.1


def test_description_is_json_whatever_the_parameters(gait: Gait) -> None:
    description = Everything(TABLE_ONE, gait).describe()
    assert json.loads(json.dumps(description, allow_nan=False)) == description
    robot = TABLE_ONE.to_dict()
    assert description == {
        "name": "Everything",
        "robot": robot,
        "gait": {"slope": gait.slope, "robot": robot},
        "gain": 1.5,
        "count": 3,
        "switch": True,
        "word": "x",
        "nothing": None,
        "table": "array([0., 1., 2.])",
    }


def test_passive_controller_gives_no_torque_and_keeps_nothing() -> None:
    passive = PassiveController()
    memory: list[float] = []
    passive.start(memory, (0.1, -0.1), (0.0, 0.0))
    assert tuple(passive.torque(memory, 0.3, (0.5, -0.2), (3.0, 4.0))) == (0.0, 0.0)
    assert (passive.states, passive.memory_size, passive.robot, passive.gait) == ((), 0, None, None)
    assert passive.describe() == {"name": "PassiveController"}
    assert passive == PassiveController()


def test_passive_controller_walks_the_passive_gait(gait: Gait) -> None:
    rates = motion(PassiveController(), [], gait.slope)
    solution = solve_ivp(rates, (0.0, gait.period), gait.start, "DOP853", rtol=1e-11, atol=1e-12)
    q, dq = TABLE_ONE.impact(solution.y[:2, -1], solution.y[2:, -1])
    # a few dozen steps of 1e-11, grown by the motion's own instability (exp(3 * 0.76) = 10)
    np.testing.assert_allclose([*q, *dq], gait.start, rtol=0, atol=1e-8)


class Leaning(AdaptiveController):
    """Begins its memory in a way of its own: no law for compilation says what `start` does."""

    def start(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        super().start(memory, q, dq)
        memory[0] = 0.01


class Weak(AdaptiveController):
    """A torque of its own, which the law that it inherits does not know."""

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        ankle, hip, *rates = super().torque(memory, t, q, dq)
        return 0.5 * ankle, 0.5 * hip, *rates


@pytest.mark.parametrize(("kind", "compiled"), [(AdaptiveController, True), (Leaning, True), (Weak, False)])
def test_a_law_is_compiled_unless_a_method_is_newer(kind: type[AdaptiveController], compiled: bool, gait: Gait) -> None:
    law = compilable_law(kind(TABLE_ONE, gait))
    assert (law is not None) == compiled


def test_methods_are_the_laws_functions_with_parameters_that_python_reads_fast(gait: Gait) -> None:
    controller = AdaptiveController(TABLE_ONE, gait)
    plain, memory = controller.plain_law, [0.0] * controller.memory_size
    q, dq = (-0.2, 0.21), (1.0, 0.7)
    controller.start(memory, q, dq)
    out = [math.nan] * (4 + ROOM)
    plain.torque(plain.parameters, memory, 0.1, q, dq, out)
    assert controller.torque(memory, 0.1, q, dq) == tuple(out[:4])
    assert {type(each) for each in plain.parameters} == {float}
    assert controller.law() is plain


def test_a_walk_asks_once_who_drives_the_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Robot] = []
    driving = PassiveController.driving

    def counted(self: PassiveController, robot: Robot) -> Controller:
        asked.append(robot)
        return driving(self, robot)

    monkeypatch.setattr(PassiveController, "driving", counted)
    mjbiped.walk(PassiveController(), mjbiped.Terrain.incline(2.0), engine="hybrid", steps=1)
    assert asked == [TABLE_ONE]


@pytest.mark.parametrize("robot", [mjbiped.Compass(), mjbiped.KneedBiped()])
def test_it_has_a_torque_for_each_joint_of_the_robot_that_it_drives(robot: Robot) -> None:
    driver = Unpowered().driving(robot)
    zeros = (0.0,) * len(robot.joints)
    assert driver.joints == robot.joints
    assert tuple(driver.torque([], 0.0, zeros, zeros)) == zeros
    law = driver.law()
    assert law is not None
    out = [1.0] * (len(zeros) + ROOM)
    law.torque(law.parameters, [], 0.0, zeros, zeros, out)
    assert tuple(out[: len(zeros)]) == zeros
    assert Unpowered().joints == mjbiped.Compass.joints


def test_a_law_of_ones_own_that_is_derived_from_it_drives_knees_too() -> None:
    class HipSpring(PassiveController):
        def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
            return 0.0, -1.0 * (q[1] - q[0]), 0.0

    ground = mjbiped.Terrain.incline(2.5)
    robot = mjbiped.KneedBiped()
    walk = mjbiped.walk(HipSpring(), ground, robot=robot, engine="hybrid", steps=1, initial="gait")
    assert walk.peak_torque[1] > 0.1
