"""The contract of a controller: gains, a memory of plain numbers, and laws that turn a state into torques.

Write your own by deriving from `Controller` and giving it a `torque` method:

```python
class HipSpring(Controller):
    def torque(self, memory, t, q, dq):
        return 0.0, -20.0 * (q[1] - q[0])
```
"""

from __future__ import annotations

import copy
import dataclasses
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, MutableSequence, Sequence
from functools import cached_property
from numbers import Real
from typing import Any, ClassVar, NamedTuple, TypeAlias

from mjbiped.gaits.gait import Gait
from mjbiped.robots.compass import Compass
from mjbiped.robots.robot import Robot

Numbers: TypeAlias = Sequence[float]
"""Numbers that a law reads: a list or tuple in Python, an array where compiled."""

Room: TypeAlias = MutableSequence[float]
"""Numbers that a law writes."""

Memory = MutableSequence[float]
"""A controller's memory: floats that the engine keeps, copies and saves; a list in Python, an array where compiled."""

ROOM = 64
"""Floats behind torques and rates in `out` of `Law.torque`, for a law's intermediate results."""


def never(parameters: object, memory: Memory, t: float) -> float:  # noqa: ARG001 (a law has all of them)
    """Return infinity: `Law.next_discontinuity` of a law without kinks."""
    return math.inf


def _do_nothing(parameters: object, memory: object, first: object, q: object, dq: object) -> None:
    """Change nothing at a touchdown or a knee strike."""


def _no_estimate(_parameters: object, _memory: object) -> float:
    return math.nan


class Law(NamedTuple):
    """A controller's laws as functions of arrays, which Numba can compile; for engines that do so.

    The functions say what the controller's methods of like names say, and those call them: one law, one place. They
    stand at the top level of a module and call only others that do. All sequences are lists of floats in plain Python
    and contiguous arrays of float64 in machine code: they are indexed, never resized. The functions allocate nothing
    (no list, array or string) and raise nothing; a function that they call may return several numbers as a tuple.

    A state is the robot's n angles q (rad) and their rates dq (rad/s): 2 with straight legs, 3 with knees.

    Attributes:
        parameters: All that the laws need besides the memory: one flat sequence of floats.
        torque: (parameters, memory, t, q, dq, out): writes the torque of each joint (N m), then the rate of each state
            (1/s), into `out`. Behind these stand `ROOM` floats for intermediate results.
        touchdown: (parameters, memory, q_before, q, dq), as `Controller.on_touchdown`; unless given, nothing happens.
        slope_estimate: (parameters, memory) -> float, rad; unless given, NaN.
        next_discontinuity: (parameters, memory, t) -> float, s; `never` unless given.
        tick: (parameters, memory, t, q, dq), as `Controller.on_tick`; None where nothing happens.
        knee_strike: (parameters, memory, t, q, dq), as `Controller.on_knee_strike`; unless given, nothing happens.
    """

    parameters: Sequence[float]
    torque: Callable[..., None]
    touchdown: Callable[..., None] = _do_nothing
    slope_estimate: Callable[..., float] = _no_estimate
    next_discontinuity: Callable[..., float] = never
    tick: Callable[..., None] | None = None
    knee_strike: Callable[..., None] = _do_nothing

    @property
    def functions(self) -> dict[str, Callable[..., Any]]:
        """All functions that are not None, by their names."""
        return {name: each for name, each in self._asdict().items() if name != "parameters" and each is not None}


class Controller(ABC):
    """A walking controller, the same for every engine.

    A controller knows what a blind robot can feel: its joint angles against the ground under the stance foot, their
    rates, and the moment of touchdown. It knows neither gravity's direction nor the terrain.

    | call | when | what it does |
    |---|---|---|
    | `start` | once, at the beginning of a walk | sets up its memory |
    | `on_touchdown` | once per support transfer, with the state just after it | what changes from step to step |
    | `on_tick` | once per `control_period` of a digital law, before `torque` | what changes from tick to tick |
    | `torque` | every control period | the continuous law |

    All laws are functions of their arguments and of `memory` alone, never of attributes that change: a walk can then be
    saved in the middle, resumed and repeated bit by bit. The engine integrates the first `len(states)` numbers of the
    memory with the rates that `torque` returns; the others change in all methods but `torque`.

    Attributes:
        states: Names of the integrated states, in the order of their indices in the memory.
        memory_size: Floats needed in all, the integrated states included.
        joints: Names of the joints that the law drives, as `Robot.joints` has them; with knees q, dq and torques have
            three numbers each.
        control_period: Time between two ticks of a digital law, s: both engines call `on_tick` and `torque` once in it,
            and motors hold their torques in between; None: the law is continuous, and the engine says how often it is
            asked.
        for_joints: Classes of the same law for robots that have a joint, as "module:Class", by the joint's name; the
            first that fits is taken.
        with_file: Class of controllers NAME:FILE that a file describes, with the fields `file` and `sha256`.
        follows: Whether the law follows the gait's trajectory in time; one that imitates passive walking itself takes
            passive gaits alone.
        support: Index in the memory of two numbers that an engine in which feet can tip writes just before
            `on_touchdown`: how far behind and ahead of its ankle the ground bears the new stance foot, m; -1: the law
            does without. In the first step they are what `start` has made of them.
        robot: The robot model that the laws use, or None; the walking robot is this one unless told otherwise.
        gait: The gait that is imitated, or None; a walk with `initial="gait"` starts on it.
        inner: The controller that this one is put around, or None. The parameters of this one's law are then a block
            (`mjbiped.numerics.blocks`) whose field `inner` is a list of one `Law`: that of the inner controller.
    """

    states: ClassVar[tuple[str, ...]] = ()
    memory_size: ClassVar[int] = 0
    joints: ClassVar[tuple[str, ...]] = Compass.joints
    control_period: float | None = None
    for_joints: ClassVar[Mapping[str, str]] = {}
    with_file: ClassVar[str | None] = None
    follows: ClassVar[bool] = True
    support: ClassVar[int] = -1
    robot: Robot | None = None
    gait: Gait | None = None
    inner: Controller | None = None

    def driving(self, robot: Robot) -> Controller:
        """The controller that drives a given robot on behalf of this one: by default itself, whatever the robot."""
        return self

    @classmethod
    def drives(cls, robot: Robot) -> bool:
        """Whether the law drives the joints that a robot has."""
        return robot.joints == cls.joints

    def start(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:  # noqa: B027 (optional hook)
        """Begin a walk.

        Args:
            memory: All zeros; to be filled.
            q: Stance and swing angle from the ground's normal under the stance foot, rad.
            dq: Their rates, rad/s.
        """

    def on_touchdown(  # noqa: B027 (optional hook)
        self, memory: Memory, q_before: Sequence[float], q: Sequence[float], dq: Sequence[float]
    ) -> None:
        """Update the memory after a support transfer.

        Args:
            memory: Memory of the controller, which is changed in place.
            q_before: Angles at touchdown in the roles and against the ground normal of the step that ends, rad.
            q: The same posture in the new roles and against the new ground's normal, rad.
            dq: Rates just after the impact in the new roles, rad/s.
        """

    def on_knee_strike(  # noqa: B027 (optional hook)
        self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]
    ) -> None:
        """Update the memory after the swing knee has struck its stop and is locked, for robots with knees.

        Args:
            memory: Memory of the controller, which is changed in place.
            t: Time since the support transfer, s.
            q: Stance leg, swing thigh and swing shank from the ground's normal under the stance foot, rad.
            dq: Their rates just after the strike, rad/s.
        """

    def on_tick(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> None:  # noqa: B027 (hook)
        """Update the memory once in each `control_period`, just before `torque` is asked with the same arguments.

        Args:
            memory: Memory of the controller, which is changed in place.
            t: Time since the support transfer, s.
            q: Stance and swing angle from the ground's normal under the stance foot, rad.
            dq: Their rates, rad/s.
        """

    @abstractmethod
    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        """Joint torques at the current time and state.

        Args:
            memory: Not to be changed here.
            t: Time since the support transfer, s.
            q: Stance and swing angle from the ground's normal under the stance foot, rad.
            dq: Their rates, rad/s.

        Returns:
            Ankle torque and hip torque, and a swing knee's, N m, followed by the rate of each of `states`, 1/s.
        """

    def slope_estimate(self, memory: Memory) -> float:
        """The controller's estimate of the slope under its stance foot, rad; NaN where it has none."""
        return math.nan

    def lateral_estimate(self, memory: Memory) -> float:
        """The controller's estimate of the slope towards the swing side, rad, in space; NaN where it has none."""
        return math.nan

    def next_discontinuity(self, memory: Memory, t: float) -> float:
        """The first time after t at which `torque` may jump or have a kink, s since the support transfer, or infinity.

        No integration step of the hybrid engine goes across it. Without it a law that is not smooth costs many short
        steps, no more.
        """
        return math.inf

    def law(self) -> Law | None:
        """The laws for compilation; None if an engine shall call the methods, with the same result, but slower."""
        return None

    def describe(self) -> dict[str, Any]:
        """Name and parameters in plain JSON types, for the record of a walk."""
        description: dict[str, Any] = {"name": type(self).__name__}
        fields: tuple[dataclasses.Field[Any], ...] = dataclasses.fields(self) if dataclasses.is_dataclass(self) else ()
        for name, value in ((field.name, getattr(self, field.name)) for field in fields):
            if isinstance(value, Gait):
                value = value.describe()
            elif isinstance(value, Robot):
                value = value.to_dict()
            elif dataclasses.is_dataclass(value) and not isinstance(value, type):
                value = dataclasses.asdict(value)
            elif isinstance(value, Real) and not isinstance(value, bool | int | float):
                value = float(value)  # NumPy's
            elif not isinstance(value, bool | int | float | str | None):
                value = repr(value)
            description[name] = value
        return description


class LawController(Controller):
    """A controller whose methods call the functions of its law: each is written once, and compiled as it stands."""

    @property
    @abstractmethod
    def plain_law(self) -> Law:
        """The law, with its parameters in a list, which plain Python reads faster than an array."""

    def on_touchdown(self, memory: Memory, q_before: Sequence[float], q: Sequence[float], dq: Sequence[float]) -> None:
        """Update the memory after a support transfer; see `Controller.on_touchdown`."""
        self.plain_law.touchdown(self.plain_law.parameters, memory, q_before, q, dq)

    def on_knee_strike(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> None:
        """Update the memory after the knee strike; see `Controller.on_knee_strike`."""
        self.plain_law.knee_strike(self.plain_law.parameters, memory, t, q, dq)

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        """Joint torques and the rates of the states; see `Controller.torque`."""
        law, count = self.plain_law, len(self.joints) + len(self.states)
        out = [0.0] * (count + ROOM)
        law.torque(law.parameters, memory, t, q, dq, out)
        return tuple(out[:count])

    def slope_estimate(self, memory: Memory) -> float:
        """The controller's estimate of the slope under its stance foot, rad."""
        return self.plain_law.slope_estimate(self.plain_law.parameters, memory)

    def next_discontinuity(self, memory: Memory, t: float) -> float:
        """The first time after t at which `torque` may have a kink, s; see `Controller.next_discontinuity`."""
        return self.plain_law.next_discontinuity(self.plain_law.parameters, memory, t)

    def law(self) -> Law:
        """The law for compilation; see `Controller.law`."""
        return self.plain_law


@dataclasses.dataclass(frozen=True)
class Unpowered(LawController):
    """Zero torque at all joints of any robot, for walks without a controller from `controllers`."""

    def driving(self, robot: Robot) -> Controller:
        """Return a copy of the controller with as many torques as the robot has joints."""
        if robot.joints == self.joints:
            return self
        driver = copy.copy(self)
        object.__setattr__(driver, "joints", robot.joints)
        return driver

    @classmethod
    def drives(cls, robot: Robot) -> bool:
        """Whether the robot has joints, which may be any: they are left alone."""
        return bool(robot.joints)

    @cached_property
    def plain_law(self) -> Law:
        """Law that applies no torque in any state."""
        return Law([], _no_torque)


def _no_torque(parameters: Numbers, memory: Memory, t: float, q: Numbers, dq: Numbers, out: Room) -> None:  # noqa: ARG001
    for joint in range(len(q)):
        out[joint] = 0.0
