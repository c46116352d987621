"""What optimised gaits of all robots have in common: what they were found for, and what they ask of the robot."""

from __future__ import annotations

import dataclasses
from abc import abstractmethod
from functools import cached_property
from typing import Any

import numpy as np

from mjbiped.gaits.optimisation import Goal, Solution, StepModel, Told, tell
from mjbiped.robots.robot import Array, Robot


class Found:
    """A solution of the optimiser as a gait; frozen dataclasses derive from it, which name the attributes.

    Attributes:
        robot: Whose gait it is.
        goal: What was asked for.
        clearance_phase: See `Solution`.
        control_points: See `Solution`.
        end: State just before the heel strike; the stance leg's angle stands first.
        period: s.
        step_length: m.
    """

    robot: Robot
    goal: Goal
    clearance_phase: float
    control_points: Array
    end: Array
    period: float
    step_length: float

    @property
    @abstractmethod
    def model(self) -> StepModel:
        """The robot's step as the optimiser takes it."""

    @property
    def own(self) -> Array:
        """The numbers that the robot adds to those of all robots; see `Solution`."""
        return np.empty(0)

    @property
    def speed(self) -> float:
        """Mean speed along the ground, m/s."""
        return self.step_length / self.period

    @cached_property
    def measures(self) -> Told:
        """What the gait asks on level ground, tracked without error: cost, torques, forces, clearance."""
        half = float(self.end[0])
        return tell(
            self.model, self.goal, Solution(self.clearance_phase, half, self.control_points, self.own, self.period)
        )

    @property
    def cost_of_transport(self) -> float:
        """Absolute work on level ground for weight and distance, c_mt."""
        return self.measures.cost_of_transport

    def describe(self) -> dict[str, Any]:
        """The trajectory and what it was found for, in plain JSON types; `gait_from` reads it."""
        return {
            "goal": dataclasses.asdict(self.goal),
            "clearance_phase": self.clearance_phase,
            "half_angle": float(self.end[0]),
            "control_points": self.control_points[2:-1].tolist(),
            **({"own": self.own.tolist()} if len(self.own) else {}),
            "robot": self.robot.to_dict(),
        }

    def __repr__(self) -> str:
        """One line."""
        return (
            f"<{type(self).__name__} at {self.speed:.4g} m/s with {self.goal.clearance:.4g} m of clearance: "
            f"c_mt {self.cost_of_transport:.4f}, period {self.period:.6g} s, step {self.step_length:.6g} m>"
        )

    def __eq__(self, other: object) -> bool:
        """Whether it is the same trajectory of the same robot, found for the same goal."""
        return isinstance(other, Found) and type(other) is type(self) and self._key == other._key

    def __hash__(self) -> int:
        """Of what makes gaits equal."""
        return hash(self._key)

    @property
    def _key(self) -> tuple[Any, ...]:
        return self.robot, self.goal, self.clearance_phase, self.control_points.tobytes(), self.own.tobytes()
