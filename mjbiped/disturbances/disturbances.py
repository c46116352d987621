"""`Disturbances`: noise, delay, motor limits and pushes that a walk is subject to, in SI units."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from typing import Annotated, Any

import numpy as np

from mjbiped.disturbances.chance import Pushes, Sensors, following, words_of
from mjbiped.errors import InputError, shown
from mjbiped.utils import domains
from mjbiped.utils.domains import Count, Domain, OneOrEach, check_fields, entries, known_name

DEFAULT_PERIOD = 1e-3
"""Time between two ticks of a disturbed control loop, unless given, s."""

PUSHES = Count(0, 10_000)  # a record has room for so many
LONGEST_DELAY = 256
"""The longest delay, in ticks."""


@dataclass(frozen=True)
class Disturbances:
    """Disturbances of a walk, all of them off by default; docs/disturbances.md explains and measures them.

    ```python
    disturbances = mjbiped.Disturbances(angle_noise=0.005, rate_noise=0.05, delay=0.01, torque_limit=50)
    walk = mjbiped.walk(controller, terrain, disturbances=disturbances)
    ```

    With anything given but pushes and friction, the controller is a digital one in either engine: it reads its sensors
    once in every `control_period`, and its motors hold their torques until the next tick.

    Sensors are the encoders and rate sensors of all joints: the ankle's measure the stance leg against the ground's
    normal, the hip's the angle from the left to the right leg or thigh, a knee's its flexion. An encoder reads
    `angle + angle_bias + noise`, rounded to `angle_resolution`; the posture that the controller is told at a touchdown
    is read by the same encoders.

    Attributes:
        angle_noise: Standard deviation of the noise of each joint's angle, new in each tick, rad.
        rate_noise: Standard deviation of the noise of each joint's rate, rad/s.
        angle_bias: Constant error of each joint's angle, rad.
        rate_bias: Constant error of each joint's rate, rad/s.
        angle_resolution: Step of the encoders, rad; 0: none.
        control_period: Time between two ticks of the controller, s; in MuJoCo a multiple of the timestep. Unless given,
            that of the engine `Mujoco`, if that has one, else 1 ms, or MuJoCo's timestep where that is longer.
        delay: Time from reading the sensors until the torque acts, s; a multiple of the control period, and at most
            256 of them.
        torque_limit: Greatest torque of all motors, N m, or one number for each of the robot's joints, as (30, 20) for
            ankle and hip; None: any.
        motor_bandwidth: Frequency at which a motor gives 1/sqrt(2) of a torque's amplitude (a lag of first order), Hz;
            None: motors follow at once. The delayed torque is limited, then lagged.
        pushes: Horizontal pushes at the hip: pairs of the time at which one begins (s) and its impulse (N s, forward
            positive), in order of time.
        push_direction: Direction of all pushes, rad: 0 pushes forward, a right angle to the left. Planar robots take no
            other than 0.
        push_impulse: Size of random pushes, forward or backward by chance, N s; instead of `pushes`.
        push_interval: Mean time from the end of a random push to the next one, s; the times are exponentially
            distributed.
        push_duration: Duration of a push, during which its force is constant, s.
        friction: Coefficient of Coulomb friction between feet and ground; None: 0.8. In MuJoCo alone: the hybrid
            engine's stance foot never slips, and its record says for how much friction a walk asks.
        seed: Seed of noise and random pushes; the same seed gives the same noise and pushes in both engines.

    Raises:
        InputError: A value is outside its domain, or contradicts another.
    """

    angle_noise: Annotated[float, domains.ANGLE_NOISE] = 0.0
    rate_noise: Annotated[float, Domain(0.0, 1e3, "rad/s")] = 0.0
    angle_bias: Annotated[float, Domain(-1.0, 1.0, "rad")] = 0.0
    rate_bias: Annotated[float, Domain(-1e3, 1e3, "rad/s")] = 0.0
    angle_resolution: Annotated[float, domains.ANGLE_NOISE] = 0.0
    control_period: Annotated[float | None, domains.CONTROL_PERIOD] = None
    delay: Annotated[float, Domain(0.0, 1e3, "s")] = 0.0
    torque_limit: Annotated[float | tuple[float, ...] | None, OneOrEach(domains.TORQUE_LIMIT)] = None
    motor_bandwidth: Annotated[float | None, Domain(1e-3, 1e9, "Hz")] = None
    pushes: Sequence[tuple[float, float]] = ()
    push_direction: Annotated[float, domains.ANGLE] = 0.0
    push_impulse: Annotated[float, domains.IMPULSE] = 0.0
    push_interval: Annotated[float | None, Domain(1e-3, 1e9, "s")] = None
    push_duration: Annotated[float, Domain(1e-3, 10.0, "s")] = 0.05
    friction: Annotated[float | None, domains.Domain(0.0, 1e3)] = None
    seed: Annotated[int, domains.SEED] = 0

    def __post_init__(self) -> None:
        """Check the values."""
        check_fields(self)
        object.__setattr__(self, "pushes", _checked_pushes(self.pushes, self.push_duration))
        if (self.push_impulse != 0.0) != (self.push_interval is not None):
            raise InputError(
                f"push_impulse = {self.push_impulse:g}, push_interval = {self.push_interval}: random pushes need both, "
                "an impulse (N s) and the mean time between them (s)"
            )
        if self.pushes and self.push_impulse != 0.0:
            raise InputError("pushes and push_impulse are both given; a walk has pushes at given times or random ones")

    @property
    def in_loop(self) -> bool:
        """Whether anything acts on the control loop: all but pushes, friction and seed."""
        names = [name for name in _USUAL if name not in ("seed", "friction") and not name.startswith("push")]
        return any(getattr(self, name) != _USUAL[name] for name in names)

    @property
    def schedule(self) -> Pushes:
        """Pushes in the form that engines take."""
        times, impulses = np.array(self.pushes, dtype=np.float64).reshape(-1, 2).T.copy()
        random = self.push_impulse, self.push_interval or 0.0
        return Pushes(times, impulses, len(times), self.push_duration, *random, *words_of(self.seed))

    @property
    def sensors(self) -> Sensors:
        """Errors of the sensors in the form that engines take."""
        noise, bias = (self.angle_noise, self.rate_noise), (self.angle_bias, self.rate_bias)
        return Sensors(*noise, *bias, self.angle_resolution, *words_of(self.seed))

    def pushes_until(self, time: float) -> tuple[tuple[float, float], ...]:
        """List the pushes, given or random, that begin before a time: times (s) and impulses (N s).

        Args:
            time: Since the walk's start, s.

        Raises:
            InputError: The time is outside its domain.
        """
        domains.TIME.check("time", time)
        schedule = self.schedule
        found: list[tuple[float, float]] = []
        while (push := following(schedule, len(found), found[-1][0] + self.push_duration if found else 0.0))[0] < time:
            found.append(push)
        return tuple(found)

    def period(self, given: float | None, shortest: float) -> float:
        """Time between two ticks in an engine, s.

        Args:
            given: Control period of the engine, s; None if it has none.
            shortest: Shortest period that the engine can have, s.

        Raises:
            InputError: The engine has another period than these disturbances.
        """
        if self.control_period is None:
            return given or max(DEFAULT_PERIOD, shortest)
        if given is not None and given != self.control_period:
            raise InputError(
                f"control_period = {self.control_period:g} of disturbances or controller contradicts control_period = "
                f"{given:g} of engine or controller; give one of them"
            )
        return self.control_period

    def delay_ticks(self, period: float) -> int:
        """Convert the delay to ticks.

        Raises:
            InputError: The delay is no whole number of ticks, or too many.
        """
        ticks = round(self.delay / period)
        if abs(ticks * period - self.delay) > 1e-6 * period:
            raise InputError(f"delay = {self.delay:g}: must be a multiple of the control period {period:g} s")
        if ticks > LONGEST_DELAY:
            raise InputError(
                f"delay = {self.delay:g}: must be at most {LONGEST_DELAY} control periods of {period:g} s; give a "
                "longer control_period"
            )
        return ticks

    def torque_limits(self, joints: Sequence[str]) -> list[float]:
        """Greatest torque of the motor of each joint, N m; infinity: any.

        Raises:
            InputError: There are neither one limit nor as many as joints.
        """
        if not isinstance(self.torque_limit, tuple):
            return [math.inf if self.torque_limit is None else self.torque_limit] * len(joints)
        if len(self.torque_limit) != len(joints):
            raise InputError(
                f"torque_limit = {shown(self.torque_limit)}: expected one number for all motors, or one for each of "
                f"{', '.join(joints)}"
            )
        return list(self.torque_limit)

    def to_dict(self) -> dict[str, Any]:
        """Values that differ from the defaults, in plain JSON types, for the record."""
        given = asdict(self)
        given["pushes"] = [list(push) for push in self.pushes]
        if isinstance(self.torque_limit, tuple):
            given["torque_limit"] = list(self.torque_limit)
        return {name: value for name, value in given.items() if value != _USUAL[name] and value != []}

    @classmethod
    def from_dict(cls, given: Mapping[str, Any]) -> Disturbances:
        """Make disturbances from the dictionary that `to_dict` returned.

        Raises:
            InputError: A name is unknown, or a value outside its domain.
        """
        for name in given:
            known_name("disturbance", name, _USUAL)
        return cls(**given)


SETTINGS = tuple(field.name for field in fields(Disturbances) if field.name != "pushes")
"""Names of the disturbances that are one number each."""

_USUAL: dict[str, object] = {field.name: field.default for field in fields(Disturbances)}


def _checked_pushes(pushes: object, duration: float) -> tuple[tuple[float, float], ...]:
    """Check pushes, and return them as pairs of plain numbers.

    Raises:
        InputError: They are not pairs, or not one after the other.
    """
    if entries(pushes) == ():
        return ()
    pairs = domains.PUSH.array("pushes, pairs of time (s) and impulse (N s)", pushes, (None, 2))
    PUSHES.check("number of pushes", len(pairs))
    times = domains.TIME.array("times of pushes", pairs[:, 0], None)
    early = np.flatnonzero(times[1:] < times[:-1] + duration)
    if early.size:
        raise InputError(
            f"pushes: the one at {times[early[0] + 1]:g} s begins before the one before it has ended; give them in "
            f"order of time, at least push_duration = {duration:g} s apart"
        )
    return tuple((time, impulse) for time, impulse in pairs.tolist())


UNDISTURBED = Disturbances()
"""No disturbances."""
