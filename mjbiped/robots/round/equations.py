"""The compass biped on round feet in event-driven engines: its equations and its reset map, as `Equations`."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from mjbiped.robots.bent_leg import straight_leg
from mjbiped.robots.chain import solve
from mjbiped.robots.equations import Equations
from mjbiped.robots.round.linkage import accelerate, gather, rolling_force, turn
from mjbiped.robots.straight_legs import lands, limbs, lock_knee

if TYPE_CHECKING:
    from mjbiped.robots.round.biped import RoundCompass


def constants_of(robot: RoundCompass) -> SimpleNamespace:
    """The robot's linkage, with room to compute in."""
    stance = straight_leg(robot.leg_length - robot.foot_radius)
    return SimpleNamespace(chain=robot.linkage.with_room(), stance=stance, thigh=1, shank=1)


def accelerations(c: Any, w: Any, q: Any, dq: Any, torques: Any, push: float) -> tuple[float, float]:
    """Accelerations of stance and swing leg, rad/s^2."""
    s = c.chain
    s.force[0], s.force[1] = torques[0] - torques[1] + push, torques[1]
    accelerate(s, q, dq, w.slope)
    return s.force[0], s.force[1]


def stop_foot(*_: Any) -> float:
    """Do nothing: a plane has no face that a foot could strike."""
    return 0.0


def exchange(c: Any, _: Any, q: Any, dq: Any, __: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Angles and rates after the heel strike, in the new roles."""
    s, new = c.chain, (q[1], q[0])
    gather(s, q, dq, new)
    solve(s.matrix, s.force)
    return new, (s.force[0], s.force[1])


def ground_force(c: Any, w: Any, weight: float, _: Any, state: Any, ddq: Any, first: int) -> tuple[float, float]:
    """Force of the ground, forward and upward, N; see `Equations`."""
    turn(c.chain, state)
    forward, upward = rolling_force(c.chain, w.slope, state, ddq, first)
    return forward, upward + weight


EQUATIONS = Equations(constants_of, accelerations, stop_foot, lands, exchange, lock_knee, limbs, ground_force)
