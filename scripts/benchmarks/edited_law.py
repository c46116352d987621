"""A user's program with a control law of its own, a constant of which the benchmark `edited` changes from run to run.

The paper's law without re-planning, the hip torque multiplied by that constant, is walked 60 steps on level ground. It
is put together here as its author would do it, so that a law of usual length has to be compiled:

    python edited_law.py ENGINE
"""

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass

import mjbiped
from controllers import AdaptiveController
from mjbiped.control.controller import Law, Memory
from mjbiped.controllers.adaptive import Parameters
from mjbiped.controllers.slope_estimator import estimate_rates
from mjbiped.controllers.tracking import tracking_errors, tracking_torque
from mjbiped.gaits.reference import reference_at
from mjbiped.robots import compass

FACTOR = 1.0


def law_torque(
    parameters: Parameters, memory: Memory, t: float, q1: float, q2: float, dq1: float, dq2: float
) -> Sequence[float]:
    """Torques (14), the hip's times `FACTOR`, and the rates of the estimates (17)."""
    reference = reference_at(parameters.table, t)
    legs = compass.legs_of(q1, q2)
    errors = tracking_errors(parameters.gains.position, reference, q1, q2, dq1, dq2)
    ankle, hip = tracking_torque(
        parameters.constants,
        parameters.gains.position,
        parameters.gains.velocity,
        reference,
        errors,
        legs,
        dq1,
        dq2,
        memory[0],
        memory[1],
    )
    rates = estimate_rates(parameters.constants, parameters.gains.adaptation, legs, errors[4], errors[5])
    return ankle, FACTOR * hip, rates[0], rates[1]


@dataclass(frozen=True)
class Edited(AdaptiveController):
    """The adaptive controller with that torque."""

    def law(self) -> Law:
        """The laws for compilation."""
        return super().law()._replace(torque=law_torque)


if __name__ == "__main__":
    robot = mjbiped.Compass()
    controller = Edited(robot, mjbiped.find_passive_gait(robot, math.radians(2)))
    walk = mjbiped.walk(controller, mjbiped.Terrain.level(), engine=sys.argv[1], steps=60)
    print(walk.outcome, walk.cost_of_transport)
