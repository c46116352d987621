"""Indices of the paper's law: intermediate results and memory; `mjbiped.controllers.layout` has the parameters'."""

from __future__ import annotations

ANGLES = 3
"""Greatest number of segments that move."""

ROOM = 16
"""First index of the room for intermediate results: behind the numbers that `torque` returns, and within the memory for
touchdowns. Nothing is kept there from one call to the next."""

Q, DQ, SINE, COSINE, REFERENCE, MOTION, ERROR, FORCE, FORWARD, UPWARD, BY_STANCE, TORQUE, ALONG, NORMAL = (
    ROOM + place for place in (0, 3, 6, 9, 12, 21, 24, 27, 30, 33, 36, 39, 42, 43)
)
"""Indices in the room: angles (rad), their rates (rad/s), sines and cosines; reference as `reference_at` writes it;
accelerations (rad/s²); z2 (rad/s); generalised forces (N m); accelerations of the ends of unit vectors along the
segments, along the ground and along its normal (1/s²); change of the forces by the stance leg's acceleration (kg m²);
torques (N m); and the ground's force along it and normal to it (N)."""


POINTS = 6
"""Control points of one angle's transition curve."""

SIN, COS, REPLANNED, LOCKED, BUMP, BENT, LEAN = range(7)
"""Indices of the estimates of the slope's sine and cosine; whether this step is re-planned; whether the swing knee is
locked; bump of the shank's curve, rad; flexion of the locked stance knee, rad; and lean of a bent stance leg's shank,
forward of the line from its foot to the hip, rad."""

SUPPORT, SUPPORT_AHEAD, CLIMBING, RECOVERING = range(7, 11)
"""Indices of how far behind and ahead of the ankle the ground bears the foot, m (`Controller.support`); of the number
of steps left with the climbing gait, this one included; and of whether this is a recovery step. The recovery step's
time (s), half angle (rad) and retraction follow."""

CURVES = ROOM + 48
"""Index in the memory of the control points of re-planned steps."""

BENT_FREE = CURVES + ANGLES * POINTS
"""Index in the memory of the chain with a bent stance leg and a free swing knee; see `chain_block`."""

BENT_STIFF = BENT_FREE + 16
"""Index of the same chain once the swing knee is locked."""

STRAIGHT_LEGS_SIZE, KNEES_SIZE = CURVES + 2 * POINTS, BENT_STIFF + 7
"""Floats of a memory of a law for straight legs, and with knees."""
