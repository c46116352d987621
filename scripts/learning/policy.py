"""The policy that is learned: a linear feedback whose gains go linearly with the time since the touchdown.

It feels what the paper's robot can feel, and remembers one number: by how much the ground has turned since the start,
which the touchdowns tell exactly (the paper's (27), from the posture at touchdown against the old ground and the new).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FEATURES = (
    "stance angle",
    "swing angle",
    "stance rate",
    "swing rate",
    "time since touchdown",
    "stance angle after touchdown",
    "slope since the start",
    "constant",
)
"""What an action is made of."""

WEIGHTS = (2, 2, len(FEATURES))
"""Shape of a policy: action (ankle, hip); constant part and part that goes with time; feature."""

PERIOD = 0.765
"""Of the passive gait on 2 degrees, s; times are told as parts of it."""
ANGLE = 0.2
"""Half the angle between the legs at that gait's touchdown, rad; angles are told as parts of it."""
SLOPE = 0.035
"""Slope that is told as 1, rad: 2 degrees."""
LATEST = 1.5
"""Parts of the period at which time stands still for the policy: a late step must not make its gains grow."""


def actions(
    weights: Array, angles: Array, rates: Array, time: Array, stance_after_touchdown: Array, slope: Array
) -> Array:
    """Torque of ankle and hip as parts of the greatest, shape (robots, 2); the task cuts off what is beyond 1.

    Args:
        weights: A policy for each robot, shape (robots, *`WEIGHTS`).
        angles: Stance and swing leg from the ground's normal under the stance foot, rad, shape (robots, 2).
        rates: Theirs, rad/s, shape (robots, 2).
        time: Since the touchdown, s, shape (robots,).
        stance_after_touchdown: Angle of the new stance leg just after it, rad; zero before the first; shape (robots,).
        slope: Of the ground since the start, rad, shape (robots,).
    """
    phase = 2.0 * np.minimum(time / PERIOD, LATEST) - 1.0  # from -1 on, 1 at the end of the gait's step
    features = np.column_stack(
        [
            angles / ANGLE,
            rates,
            phase,
            stance_after_touchdown / ANGLE + 1.0,  # near 0 on the gait
            slope / SLOPE,
            np.ones_like(phase),
        ]
    )
    with_time = np.stack([np.ones_like(phase), phase], axis=1)
    told: Array = np.einsum("nakf,nk,nf->na", weights, with_time, features)
    return told
