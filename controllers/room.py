"""Where intermediate results of the paper's law stand; see `mjbiped.controllers.layout`."""

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
