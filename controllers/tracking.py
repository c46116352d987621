"""Trajectory tracking by backstepping, section III-A of the paper, equations (5)-(14)."""

from __future__ import annotations

from mjbiped.robots import compass


def tracking_errors(
    position_gain: float,
    reference: tuple[float, float, float, float, float, float],
    q1: float,
    q2: float,
    dq1: float,
    dq2: float,
) -> tuple[float, float, float, float, float, float]:
    r"""Errors of the two backstepping stages, (5), (6) and (9).

    .. math:: z_1 = q_r - q, \quad \dot z_1 = \dot q_r - \dot q, \quad z_2 = \dot z_1 + K_1 z_1

    Args:
        position_gain: K1 = diag(k, k), 1/s.
        reference: q_r (2), its rates (2) and accelerations (2).
        q1: Stance angle, rad.
        q2: Swing angle, rad.
        dq1: Stance rate, rad/s.
        dq2: Swing rate, rad/s.

    Returns:
        z1 (2, rad), its rate (2, rad/s), z2 (2, rad/s).
    """
    z1a, dz1a, z2a = angle_errors(position_gain, reference[0], reference[2], q1, dq1)
    z1b, dz1b, z2b = angle_errors(position_gain, reference[1], reference[3], q2, dq2)
    return z1a, z1b, dz1a, dz1b, z2a, z2b


def angle_errors(position_gain: float, q_r: float, dq_r: float, q: float, dq: float) -> tuple[float, float, float]:
    """z1, its rate and z2 of one angle; see `tracking_errors`."""
    z1, dz1 = q_r - q, dq_r - dq
    return z1, dz1, dz1 + position_gain * z1


def tracking_torque(
    constants: compass.Constants,
    position_gain: float,
    velocity_gain: float,
    reference: tuple[float, float, float, float, float, float],
    errors: tuple[float, float, float, float, float, float],
    legs: compass.Legs,
    dq1: float,
    dq2: float,
    sin_slope: float,
    cos_slope: float,
) -> tuple[float, float]:
    r"""Control law (12); with the estimates for sine and cosine of the slope it is (14).

    .. math:: \tau = B^{-1}\{M[\ddot q_r + (K_1 K_2 + I) z_1 + (K_1 + K_2) \dot z_1] + C \dot q + g\}

    Args:
        constants: Lumped constants of the controller's robot model.
        position_gain: K1 = diag(k, k), 1/s.
        velocity_gain: K2 = diag(k, k), 1/s.
        reference: q_r (2), its rates (2) and accelerations (2).
        errors: As `tracking_errors` returns them.
        legs: Sine and cosine of stance and swing angle.
        dq1: Stance rate, rad/s.
        dq2: Swing rate, rad/s.
        sin_slope: Sine of the slope, or its estimate.
        cos_slope: Cosine of the slope, or its estimate.

    Returns:
        Ankle and hip torque, N m.
    """
    on_position, on_rate = feedback_gains(position_gain, velocity_gain)
    return computed_torque(constants, on_position, on_rate, reference, errors, legs, dq1, dq2, sin_slope, cos_slope)


def feedback_gains(position_gain: float, velocity_gain: float) -> tuple[float, float]:
    """K1 K2 + I (1/s²) and K1 + K2 (1/s) of (12), by which z1 and its rate are fed back."""
    return position_gain * velocity_gain + 1.0, position_gain + velocity_gain


def commanded(ddq_r: float, on_position: float, z1: float, on_rate: float, dz1: float) -> float:
    """The acceleration of one angle that (12) asks for, rad/s²."""
    return ddq_r + on_position * z1 + on_rate * dz1


def computed_torque(
    constants: compass.Constants,
    on_position: float,
    on_rate: float,
    reference: tuple[float, float, float, float, float, float],
    errors: tuple[float, float, float, float, float, float],
    legs: compass.Legs,
    dq1: float,
    dq2: float,
    sin_slope: float,
    cos_slope: float,
) -> tuple[float, float]:
    r"""Feedback linearisation: where model and slope are true, the errors obey linear equations.

    .. math:: \tau = B^{-1}\{M[\ddot q_r + k_p z_1 + k_d \dot z_1] + C \dot q + g\}
              \quad\Rightarrow\quad \ddot z_1 + k_d \dot z_1 + k_p z_1 = 0

    Args:
        constants: Lumped constants of the controller's robot model.
        on_position: k_p, 1/s².
        on_rate: k_d, 1/s.
        reference: q_r (2), its rates (2) and accelerations (2).
        errors: As `tracking_errors` returns them; the last two are not used.
        legs: Sine and cosine of stance and swing angle.
        dq1: Stance rate, rad/s.
        dq2: Swing rate, rad/s.
        sin_slope: Sine of the slope, or its estimate.
        cos_slope: Cosine of the slope, or its estimate.

    Returns:
        Ankle and hip torque, N m.
    """
    a1 = commanded(reference[4], on_position, errors[0], on_rate, errors[2])
    a2 = commanded(reference[5], on_position, errors[1], on_rate, errors[3])
    force1, force2 = compass.inverse_dynamics(constants, legs, dq1, dq2, sin_slope, cos_slope, a1, a2)
    return compass.joint_torques(force1, force2)
