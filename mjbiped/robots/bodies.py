"""The bodies that a robot consists of, for engines that build it of rigid bodies."""

from __future__ import annotations

import math
from typing import NamedTuple


class Segment(NamedTuple):
    """A segment of a leg.

    Attributes:
        name: Of what is seen of it in the robot's file in `models/`, behind the leg's name and "_".
        mass: kg.
        length: From its upper end to its lower end, m.
        centre: From its upper end down to its centre of mass, m.
        inertia: About its centre of mass, kg m^2.
        turn: Angle of its line, from end to end, when all joints of the leg are at zero, rad.
        offset: Of its centre of mass ahead of that line, m.
    """

    name: str
    mass: float
    length: float
    centre: float
    inertia: float
    turn: float = 0.0
    offset: float = 0.0

    def place(self, distance: float, ahead: float = 0.0) -> tuple[float, float]:
        """Place x, z of a point from the segment's upper end while all joints are at zero, m.

        Args:
            distance: Down the segment's line, m.
            ahead: Ahead of that line, m.
        """
        sine, cosine = math.sin(self.turn), math.cos(self.turn)
        return 0.0 - distance * sine + ahead * cosine, 0.0 - distance * cosine - ahead * sine


class Limb(NamedTuple):
    """A leg by its names in the robot's file in `models/`; its foot and its contact sensor bear the leg's name, too.

    Attributes:
        name: Of the leg.
        hinge: Joint that turns its upper segment.
        ankle: Motor that turns it against the ground.
        across: Where it is seen across the walking direction, leg lengths.
        offset: Angle of its upper segment when that of the hinge is zero, rad, where legs share a hinge.
        lap: What is added to that with each round in which all legs have stood, rad.
    """

    name: str
    hinge: str
    ankle: str
    across: float
    offset: float = 0.0
    lap: float = 0.0


SIDES = (Limb("left", "left", "left_ankle", 0.04), Limb("right", "right", "right_ankle", -0.04))
"""The legs of a biped."""


class Foot(NamedTuple):
    """A foot that turns about the end of its leg, the ankle, where its centre of mass is.

    Attributes:
        mass: kg.
        inertia: About the ankle, kg m^2.
        height: Of the ankle over the sole, m.
        behind: From below the ankle back to the heel, m.
        ahead: From below the ankle forward to the toe, m.
        box: Whether it stands on all of its sole, or only on heel and toe.
    """

    mass: float
    inertia: float
    height: float
    behind: float
    ahead: float
    box: bool


class Bodies(NamedTuple):
    """A robot's bodies.

    Attributes:
        scene: File in `models/` that holds the robot and its surroundings.
        hip_mass: Point mass at the hip, kg.
        leg: The segments of each leg, from the hip down: one, or two with a knee between them.
        limbs: The legs, in the order in which they stand.
        foot: Of each leg; None: legs end in points or arcs.
    """

    scene: str
    hip_mass: float
    leg: tuple[Segment, ...]
    limbs: tuple[Limb, ...] = SIDES
    foot: Foot | None = None

    def feet(self, limb: Limb) -> list[str]:
        """Names of the geoms with which a leg meets the ground."""
        if self.foot is None:
            return [f"{limb.name}_foot"]
        return [f"{limb.name}_sole"] if self.foot.box else [f"{limb.name}_heel", f"{limb.name}_toe"]
