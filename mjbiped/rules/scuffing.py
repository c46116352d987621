"""The scuffing rule: when a straight swing leg may touch the ground.

Straight legs of equal length must scuff: the swing foot of a passive walker passes below the ground from 8.7 cm behind
the stance foot until level with it, and is hardly above it for another 10 cm. The rule stands for a foot that is drawn
in during the early swing, as physical compass walkers do it, and is the same object in every engine. Results on
ascending steps depend on it: a riser nearer than `reach` is passed as if it were not there. A gait whose steps are
shorter than `reach` cannot land at all, and is refused before a walk. No support transfer is shorter than `reach`: a
foot that swings back and comes down nearer to the stance foot is drawn in as well, and the robot falls unless that foot
gets ahead once more.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from mjbiped.errors import InputError
from mjbiped.utils import domains
from mjbiped.utils.domains import Domain

if TYPE_CHECKING:
    from mjbiped.gaits.gait import Gait


@dataclass(frozen=True)
class ScuffingRule:
    """The swing foot starts to collide at the first moment when all three hold, and stops where it comes nearer again.

    Attributes:
        reach: Least horizontal distance of the swing foot ahead of the stance foot, in leg lengths.
        delay: Least time since the support transfer, s.
        name: Name in records; the third condition, that it is above the ground at its own position, has no parameter.
    """

    reach: Annotated[float, domains.REACH] = 0.20
    delay: Annotated[float, Domain(0.0, 1e4, "s")] = 0.1
    name: str = "drawn in until ahead"

    def __post_init__(self) -> None:
        """Refuse a reach or a delay outside its domain, and a name that is no text.

        Raises:
            InputError: A value is outside its domain; see `mjbiped.utils.domains`.
        """
        domains.check_fields(self)
        domains.check_text("name", self.name)


def chosen(scuffing: ScuffingRule | None) -> ScuffingRule:
    """Return the given rule, or the default one.

    Raises:
        InputError: The object is no scuffing rule.
    """
    return ScuffingRule() if scuffing is None else domains.check_kind("scuffing", scuffing, ScuffingRule)


def swing_foot_collides(reach: float, delay: float, time: float, ahead: float, clearance: float) -> bool:
    """Whether the rule lets the swing foot collide from now on.

    Args:
        reach: Distance ahead that the rule asks for, m (leg lengths times leg length).
        delay: Time since the support transfer that it asks for, s.
        time: Time since the support transfer, s.
        ahead: Horizontal distance of the swing foot ahead of the stance foot, m.
        clearance: Height of the swing foot over the ground at its own position, m.
    """
    return time > delay and ahead >= reach and clearance > 0.0


def swing_foot_is_drawn_in(reach: float, ahead: float) -> bool:
    """Whether a swing foot that could collide passes through the ground again, having come back too near.

    Args:
        reach: Distance ahead that the rule asks for, m.
        ahead: Horizontal distance of the swing foot ahead of the stance foot, m.
    """
    return ahead < reach


def check_landing(gait: Gait, slope: float, rule: ScuffingRule) -> None:
    """Refuse a gait whose swing foot the rule never lets touch the ground: no step of it would end.

    Args:
        gait: The gait that is walked or imitated.
        slope: Slope of the ground, rad, positive downhill.
        rule: The scuffing rule.

    Raises:
        InputError: The gait's touchdown is too near or too early.
    """
    q1, q2, *_ = gait.reference(gait.period)[0].tolist()
    ahead = math.sin(q1 + slope) - math.sin(q2 + slope)
    # just before its touchdown the foot is above the ground
    if swing_foot_collides(rule.reach, rule.delay, gait.period, ahead, math.inf):
        return
    if gait.period <= rule.delay:
        delay = _rounded_down(0.5 * gait.period)
        raise InputError(
            f"scuffing rule: a step of the gait takes {gait.period:.3g} s, and its swing foot collides only after "
            f"{rule.delay:g} s, so that it would never land; give a shorter delay, scuffing=ScuffingRule(delay={delay})"
        )
    reach = _rounded_down(0.5 * ahead)
    raise InputError(
        f"scuffing rule: the swing foot of the gait comes down {ahead:.3g} leg lengths ahead of the stance foot, and "
        f"collides only from {rule.reach:g} on, so that it would never land; give a shorter reach, "
        f"scuffing=ScuffingRule(reach={reach}) or --scuffing-reach {reach}"
    )


def _rounded_down(value: float) -> float:
    """Round a positive number down to one digit."""
    digits, _, exponent = f"{value:.17e}".partition("e")
    return float(f"{digits[0]}e{exponent}")
