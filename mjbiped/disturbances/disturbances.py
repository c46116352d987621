"""`Disturbances`: what a walk is disturbed by, in SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

from mjbiped.errors import InputError
from mjbiped.utils import domains
from mjbiped.utils.domains import check_fields, check_given_fields, known_name

DEFAULT_PERIOD = 1e-3
"""Time between two ticks of a disturbed control loop, unless given, s."""

LONGEST_DELAY = 256
"""The longest delay, in ticks: so many torques are kept."""


@dataclass(frozen=True)
class Disturbances:
    """What the real world does to a walk. All is off unless given; docs/disturbances.md explains and measures it.

    ```python
    disturbances = mjbiped.Disturbances(angle_noise=0.005, rate_noise=0.05, delay=0.01, torque_limit=50)
    walk = mjbiped.walk(controller, terrain, disturbances=disturbances)
    ```

    With anything given, the controller is a digital one in either engine: it reads its sensors once in every
    `control_period`, and its motors hold their torques until the next tick.

    Sensors are the encoders and rate sensors of both joints: the ankle's measure the stance leg against the ground's
    normal, the hip's the angle from the left to the right leg. An encoder reads `angle + angle_bias + noise`, rounded
    to `angle_resolution`; the posture that the controller is told at a touchdown is read by the same encoders.

    Attributes:
        angle_noise: Standard deviation of the noise of either joint's angle, new in each tick, rad.
        rate_noise: The same of either joint's rate, rad/s.
        angle_bias: Constant error of either joint's angle, rad.
        rate_bias: Constant error of either joint's rate, rad/s.
        angle_resolution: Step of the encoders, rad; 0: none.
        control_period: Time between two ticks of the controller, s; in MuJoCo a multiple of the timestep. Unless given,
            that of the engine `Mujoco`, if that has one, else 1 ms, or MuJoCo's timestep where that is longer.
        delay: Time from reading the sensors until the torque acts, s; a multiple of the control period, and at most
            256 of them.
        torque_limit: Greatest torque of either motor, N m; None: any.
        motor_bandwidth: Frequency at which a motor gives 1/sqrt(2) of a torque's amplitude (a lag of first order), Hz;
            None: motors follow at once.
        seed: Of the noise; the same seed gives the same noise in both engines.

    Raises:
        InputError: A value is outside its domain, or contradicts another.
    """

    angle_noise: float = 0.0
    rate_noise: float = 0.0
    angle_bias: float = 0.0
    rate_bias: float = 0.0
    angle_resolution: float = 0.0
    control_period: float | None = None
    delay: float = 0.0
    torque_limit: float | None = None
    motor_bandwidth: float | None = None
    seed: int = 0

    def __post_init__(self) -> None:
        """Check the values."""
        check_fields(
            self,
            angle_noise=domains.ANGLE_NOISE,
            rate_noise=domains.RATE_NOISE,
            angle_bias=domains.ANGLE_BIAS,
            rate_bias=domains.RATE_BIAS,
            angle_resolution=domains.ANGLE_NOISE,
            delay=domains.LOOP_DELAY,
            seed=domains.SEED,
        )
        check_given_fields(
            self,
            control_period=domains.CONTROL_PERIOD,
            torque_limit=domains.TORQUE_LIMIT,
            motor_bandwidth=domains.BANDWIDTH,
        )

    @property
    def in_loop(self) -> bool:
        """Whether anything acts on the control loop: all but the seed."""
        names = [name for name in _USUAL if name != "seed"]
        return any(getattr(self, name) != _USUAL[name] for name in names)

    def period(self, given: float | None, shortest: float) -> float:
        """Time between two ticks in an engine, s.

        Args:
            given: The engine's own, s.
            shortest: That it can have, s.

        Raises:
            InputError: The engine's own is another.
        """
        if self.control_period is None:
            return given or max(DEFAULT_PERIOD, shortest)
        if given is not None and given != self.control_period:
            raise InputError(
                f"control_period = {self.control_period:g} of the disturbances contradicts control_period = {given:g} "
                "of the engine; give one of them"
            )
        return self.control_period

    def delay_ticks(self, period: float) -> int:
        """The delay in ticks.

        Raises:
            InputError: It is no whole number of them, or too many.
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

    def to_dict(self) -> dict[str, Any]:
        """What is not as usual, in plain JSON types, for the record."""
        return {name: value for name, value in asdict(self).items() if value != _USUAL[name]}

    @classmethod
    def from_dict(cls, given: Mapping[str, Any]) -> Disturbances:
        """Those that `to_dict` has told of.

        Raises:
            InputError: A name is unknown, or a value outside its domain.
        """
        for name in given:
            known_name("disturbance", name, _USUAL)
        return cls(**given)


_USUAL: dict[str, Any] = {field.name: field.default for field in fields(Disturbances)}


UNDISTURBED = Disturbances()
"""Nothing disturbs the walk."""
