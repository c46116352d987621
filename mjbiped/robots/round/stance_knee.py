"""The torque that holds the stance knee of a biped with knees on round feet; see `mjbiped.robots.stance_knee`."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from mjbiped.numerics import jit
from mjbiped.numerics.records import in_one_block
from mjbiped.robots.chain import Array
from mjbiped.robots.round.constraints import settle
from mjbiped.robots.round.kneed_equations import APART, AS_ONE
from mjbiped.robots.round.linkage import load, turn

if TYPE_CHECKING:
    from mjbiped.robots.round.kneed import RoundKneed


def stance_knee_torques(robot: RoundKneed, q: Array, dq: Array, torque: Array, slope: Array, locked: Array) -> Array:
    """Torque that holds the stance knee at its stop in each of many instants, shape (n,), N m.

    Args:
        robot: The robot.
        q: Stance leg, swing thigh and swing shank from the ground's normal, shape (n, 3), rad.
        dq: Their rates, shape (n, 3), rad/s.
        torque: Of ankle, hip and swing knee, shape (n, 3), N m.
        slope: Of the ground, shape (n,), rad.
        locked: Whether the swing knee is locked as well, not 0 where it is, shape (n,).
    """
    found, linkages = np.empty(len(q)), robot.chains
    room = SimpleNamespace(three=linkages[3].with_room(), four=linkages[4].with_room(), q=np.zeros(4), dq=np.zeros(4))
    _machine_code()(in_one_block(room), q, dq, torque, slope, locked, found)
    return found


def hold_all(c: Any, q: Array, dq: Array, torque: Array, slope: Array, locked: Array, found: Array) -> None:
    """Write the torque of each row into `found`; see `stance_knee_torques`. Runs compiled.

    It is what the motion of the locked leg leaves over of the stance shank's equation.
    """
    three, four = c.three, c.four
    for row in range(len(found)):
        ankle, hip, knee = torque[row, 0], torque[row, 1], torque[row, 2]
        three.force[0], three.force[1], three.force[2] = ankle - hip, hip - knee, knee
        turn(three, q[row])
        load(three, dq[row], slope[row])
        settle(three, AS_ONE if locked[row] != 0.0 else APART)
        for j in range(4):
            c.q[j], c.dq[j] = q[row, max(j - 1, 0)], dq[row, max(j - 1, 0)]
        four.force[0], four.force[1], four.force[2], four.force[3] = ankle, -hip, hip - knee, knee
        turn(four, c.q)
        load(four, c.dq, slope[row])
        found[row] = four.force[0]
        for j in range(4):
            found[row] -= four.matrix[0, j] * three.force[max(j - 1, 0)]


@cache
def _machine_code() -> Any:
    """`hold_all` as machine code; compiled once, and kept on disk."""
    digest = jit.prepared((hold_all,), inlined=())
    return jit.from_source(jit.jitted, "held", _SOURCE, {"hold_all": hold_all}, digest)


_SOURCE = """
def held(c, q, dq, torque, slope, locked, found):
    hold_all(c, q, dq, torque, slope, locked, found)
"""
