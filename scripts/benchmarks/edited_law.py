"""A user's program with a control law of its own, a constant of which the benchmark `edited` changes from run to run.

The paper's law without re-planning, the hip torque multiplied by that constant, is walked 60 steps on level ground. It
is put together here as its author would do it, so that a law of usual length has to be compiled:

    python edited_law.py ENGINE
"""

import math
import sys
from collections.abc import MutableSequence, Sequence
from dataclasses import dataclass

import mjbiped
from controllers import AdaptiveController
from mjbiped.control.controller import Law, Memory
from mjbiped.controllers.dynamics import inverse_dynamics, observe, write_torques
from mjbiped.controllers.layout import ADAPTATION_GAIN, gait_of, moving_chain, table_of_step
from mjbiped.controllers.room import COS, REFERENCE, SIN
from mjbiped.controllers.slope_estimator import estimate_rates
from mjbiped.controllers.tracking import aim
from mjbiped.gaits.reference import reference_at

FACTOR = 1.0


def law_torque(
    parameters: Sequence[float],
    memory: Memory,
    t: float,
    q: Sequence[float],
    dq: Sequence[float],
    out: MutableSequence[float],
) -> None:
    """Torques (14), the hip's times `FACTOR`, and the rates of the estimates (17)."""
    n, chain, first = moving_chain(parameters, memory)
    observe(n, q, dq, out)
    reference_at(parameters, table_of_step(parameters, memory, gait_of(parameters, memory)), t, out, REFERENCE)
    aim(parameters, n, out)
    inverse_dynamics(chain, first, n, (memory[SIN], memory[COS]), out)
    write_torques(n, out, out, 0)
    out[1] = FACTOR * out[1]
    out[2], out[3] = estimate_rates(parameters[ADAPTATION_GAIN], chain, first, n, out)


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
