"""The robots as free rigid bodies in the coordinates of a posture `qpos`: mechanics that no engine computes with.

Points of the x-z plane are complex numbers x + i z. A positive angle turns the upward direction i forward, to
i exp(-i angle). The robot's equations are M a + h = forces, with M and h from the bodies' places alone (Kane).
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjbiped.robots.robot import Robot

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


class Point(NamedTuple):
    """A point of the robot: the hip plus levers that turn with angles.

    Attributes:
        levers: One for each angle, m.
        angles: Shape (levers, len(qpos)): how each angle is made up of the posture.
    """

    levers: Complex
    angles: Array

    def place(self, qpos: Array) -> complex:
        return complex(qpos[0], qpos[1]) + complex(self.levers @ np.exp(-1j * (self.angles @ qpos)))

    def jacobian(self, qpos: Array) -> Complex:
        """Velocity of the point for each rate of the posture."""
        moved = (-1j * self.levers * np.exp(-1j * (self.angles @ qpos))) @ self.angles
        return np.asarray(np.concatenate([[1.0, 1j], moved[2:]]))

    def bend(self, qpos: Array, v: Array) -> complex:
        """Acceleration of the point where the posture's rates do not change."""
        return complex(-self.levers * np.exp(-1j * (self.angles @ qpos)) @ (self.angles @ v) ** 2)


class FreeRobot:
    """A robot that nothing holds.

    Args:
        robot: The robot.
        hip_mass: Another mass at the hip than its own, kg.

    Attributes:
        ends: The end of each leg: a point foot, the ankle of a foot, or the centre of a round foot's arc.
    """

    def __init__(self, robot: Robot, hip_mass: float | None = None) -> None:
        bodies, width = robot.bodies, len(robot.places)
        self.robot, self.radius = robot, robot.radius
        self.parts: list[tuple[float, float, Point, Array]] = []
        self.ends: list[Point] = []
        nothing = Point(np.zeros(0, complex), np.zeros((0, width)))
        self.parts.append((bodies.hip_mass if hip_mass is None else hip_mass, 0.0, nothing, np.zeros(width)))
        for number, limb in enumerate(bodies.limbs):
            turns, angle, upper = np.zeros(width), limb.offset, nothing
            wheel = len(robot.places) == 3
            for k, segment in enumerate(bodies.leg):
                turns = turns.copy()
                turns[2 if wheel else 2 + 2 * k + number] = 1.0
                down = -1j * np.exp(-1j * (segment.turn + angle))
                here = np.vstack([upper.angles, turns])
                centre = Point(np.append(upper.levers, down * (segment.centre + 1j * segment.offset)), here)
                if not wheel or number == 0:
                    self.parts.append((segment.mass, segment.inertia, centre, turns))
                length = segment.length - (robot.radius if k == len(bodies.leg) - 1 else 0.0)
                upper = Point(np.append(upper.levers, down * length), here)
            self.ends.append(upper)
            if bodies.foot is not None:
                self.parts.append((bodies.foot.mass, bodies.foot.inertia, upper, turns + np.eye(width)[4 + number]))

    def mass_matrix(self, qpos: Array) -> Array:
        M = np.zeros((len(qpos),) * 2)
        for mass, inertia, centre, turns in self.parts:
            J = centre.jacobian(qpos)
            M += mass * np.outer(J.conj(), J).real + inertia * np.outer(turns, turns)
        return M

    def bias(self, qpos: Array, v: Array) -> Array:
        """Coriolis, centrifugal and gravity forces h."""
        found = np.zeros(len(qpos))
        for mass, _, centre, _ in self.parts:
            pull = centre.bend(qpos, v) + 1j * self.robot.gravity
            found += mass * (centre.jacobian(qpos).conj() * pull).real
        return found

    def energy(self, qpos: Array, v: Array) -> float:
        """Kinetic and potential energy, J."""
        height = sum(mass * centre.place(qpos).imag for mass, _, centre, _ in self.parts)
        return float(0.5 * v @ self.mass_matrix(qpos) @ v + self.robot.gravity * height)

    def momentum(self, qpos: Array, v: Array) -> complex:
        """Momentum, kg m/s."""
        return complex(sum(mass * centre.jacobian(qpos) @ v for mass, _, centre, _ in self.parts))

    def rates(self, qpos: Array, stance: int, dq: Any, slope: float) -> Array:
        """Rates of the posture that an engine's rates make, while the stance foot rests or rolls on a slope.

        Rates of four segments begin with that of the stance shank, whose knee is then free.
        """
        v = np.zeros(len(qpos))
        lowest, *dq = np.asarray(dq, dtype=float)
        if len(dq) < 3:
            dq = [lowest, *dq]
        else:
            v[4 + stance] = lowest - dq[0]
        if len(qpos) == 3:
            v[2] = dq[0]
        else:
            v[2 + stance], v[3 - stance] = dq[:2]
            if len(dq) == 3:
                v[5 - stance] = dq[2] - dq[1]
            elif len(qpos) == 6:  # feet stay parallel to the ground
                v[4:] = -v[2:4]
        end = self.ends[stance % len(self.ends)]
        foot = self.radius * lowest * np.exp(-1j * slope) - end.jacobian(qpos) @ v
        v[:2] = foot.real, foot.imag
        return v

    def motions(self, qpos: Array, stance: int, dq: Any, slope: float) -> Array:
        """Rates of the posture for each column of engine's rates, shape (len(qpos), columns)."""
        return np.stack([self.rates(qpos, stance, column, slope) for column in np.transpose(dq)], axis=1)
