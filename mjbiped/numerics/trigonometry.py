"""Sine and cosine of one angle together, written so that compiled code needs no call for the angles of walking legs."""

from __future__ import annotations

import math

EIGHTH_TURN = 0.25 * math.pi

# Chebyshev interpolants of (sin x - x) / x^3 and (cos x - 1 + x^2 / 2) / x^4 in x^2 on the eighth turn, lowest power
# first: truncation errors 2e-17 and 1e-18, below rounding
_S0, _S1, _S2 = -0.16666666666666666, 0.008333333333330948, -0.00019841269836758574
_S3, _S4, _S5 = 2.755731610255244e-06, -2.5051131845003624e-08, 1.5918129294866608e-10
_C0, _C1, _C2 = 0.041666666666666664, -0.0013888888888887398, 2.480158729876569e-05
_C3, _C4, _C5 = -2.7557317271729793e-07, 2.08761462684032e-09, -1.1382632425521717e-11


def sine_cosine(x: float) -> tuple[float, float]:
    """Sine and cosine of x (rad), each within one unit in the last place.

    Up to an eighth turn by polynomials, whose even and odd powers are summed side by side; beyond it, where legs hardly
    come, by the mathematical library, which takes four times as long.
    """
    if not abs(x) <= EIGHTH_TURN:
        return math.sin(x), math.cos(x)
    z = x * x
    y = z * z
    sine = x + x * z * ((_S0 + y * (_S2 + y * _S4)) + z * (_S1 + y * (_S3 + y * _S5)))
    rest = y * ((_C0 + y * (_C2 + y * _C4)) + z * (_C1 + y * (_C3 + y * _C5)))
    half = 0.5 * z
    coarse = 1.0 - half
    return sine, coarse + (((1.0 - coarse) - half) + rest)
