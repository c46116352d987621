"""The Runge-Kutta scheme of the hybrid engine: Dormand and Prince's pair of order 8 with dense output of order 7.

Source: Hairer, Nørsett, Wanner, Solving Ordinary Differential Equations I, sections II.5, II.6 and II.10 (DOP853); the
coefficients are those of `scipy.integrate.DOP853`, and a test compares the steps.

A state has `c.size` components, of which the first `c.judged` count in the estimate of the error. `rates(c, w, t, y,
dy)` writes the rates of a state into `dy`. The block `w` has the state at the step's start in `y` and at its end in
`out`, the rates of each stage in the rows of `k`, a state in between in `spare`, and the dense output's coefficients in
the rows of `dense`, one for each power.
"""

from __future__ import annotations

import math
from collections.abc import Callable, MutableSequence, Sequence
from typing import Protocol, TypeAlias

from mjbiped.numerics.blocks import Floats, numbers, row

Rates: TypeAlias = Callable[..., None]

STAGES = 12  # of a step; the rates at its end are stage 12, the next step's stage 0
STAGES_WITH_DENSE = 16
POWERS = 7  # of the dense output
IN_ORDER = (0, 6, 7, 5, 9, 8, 10, 12)
"""Stages in the order of their places, without those whose states lie beside the motion: up to 2e-3 of the torque."""

PLACES = (0.0, 0.25, 0.3076923076923077, 0.3333333333333333, 0.6, 0.6512820512820513, 0.8571428571428571, 1.0)
"""Where these stages lie, in shares of the step."""

PLACES_BETWEEN = (0.1, 0.2, 0.7777777777777778)
BETWEEN = ((0, 6, 7, 8, 9, 10, 11, 12), (0, 5, 6, 7, 10, 11, 12, 13), (0, 5, 6, 7, 8, 12, 13, 14))
WEIGHTS_BETWEEN = (
    (0.056167502283047954, 0.25350021021662483, -0.2462390374708025, -0.12419142326381637, 0.15329179827876568,
     0.00820105229563469, 0.007567897660545699, -0.008298),
    (0.03183464816350214, 0.028300909672366776, 0.053541988307438566, -0.05492374857139099, -0.00010834732869724932,
     0.0003825710908356584, -0.00034046500868740456, 0.1413124436746325),
    (-0.42889630158379194, -4.697621415361164, 7.683421196062599, 4.06898981839711, 0.3567271874552811,
     -0.0013990241651590145, 2.9475147891527724, -9.15095847217987),
)  # fmt: skip
ALL = (0, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)  # stages that make the dense output
HIGH = (
    (-8.428938276109013, 0.5667149535193777, -3.0689499459498917, 2.38466765651207, 2.117034582445028,
     -0.871391583777973, 2.2404374302607883, 0.6315787787694688, -0.08899033645133331, 18.148505520854727,
     -9.194632392478356, -4.436036387594894),
    (10.427508642579134, 242.28349177525817, 165.20045171727028, -374.5467547226902, -22.113666853125306,
     7.733432668472264, -30.674084731089398, -9.332130526430229, 15.697238121770845, -31.139403219565178,
     -9.35292435884448, 35.81684148639408),
    (19.985053242002433, -387.0373087493518, -189.17813819516758, 527.8081592054236, -11.57390253995963,
     6.8812326946963, -1.0006050966910838, 0.7777137798053443, -2.778205752353508, -60.19669523126412,
     84.32040550667716, 11.99229113618279),
    (-25.69393346270375, -154.18974869023643, -231.5293791760455, 357.6391179106141, 93.40532418362432,
     -37.45832313645163, 104.0996495089623, 29.8402934266605, -43.53345659001114, 96.32455395918828,
     -39.17726167561544, -149.72683625798564),
)  # fmt: skip


class Problem(Protocol):
    """The constants of a motion; see above."""

    size: int
    judged: int
    tolerance: float


class Step(Protocol):
    """A step of it; see above."""

    y: Floats
    out: Floats
    spare: Floats
    k: list[list[float]]
    dense: list[list[float]]


def step(rates: Rates, c: Problem, w: Step, t: float, h: float) -> float:
    """Integrate one step of length h from `w.y`, whose rates stand in the first row of `w.k` already, to `w.out`.

    Returns:
        The estimated error over c.tolerance (1 + |y|), a mean over the components that count: at most 1 for a good
        step.
    """
    _first_stages(rates, c, w, t, h)
    _last_stages(rates, c, w, t, h)
    _end(rates, c, w, t, h)
    return _error(c, w, h)


def _first_stages(rates: Rates, c: Problem, w: Step, t: float, h: float) -> None:
    """Compute the rates of stages 1 to 7."""
    n = c.size
    y, s = numbers(w.y, n), numbers(w.spare, n)
    k0, k1, k2, k3 = row(w.k, 0, n), row(w.k, 1, n), row(w.k, 2, n), row(w.k, 3, n)
    k4, k5, k6, k7 = row(w.k, 4, n), row(w.k, 5, n), row(w.k, 6, n), row(w.k, 7, n)
    for i in range(n):
        s[i] = y[i] + h * (0.05260015195876773 * k0[i])
    rates(c, w, t + 0.05260015195876773 * h, s, k1)
    for i in range(n):
        s[i] = y[i] + h * (0.0197250569845379 * k0[i] + 0.0591751709536137 * k1[i])
    rates(c, w, t + 0.0789002279381516 * h, s, k2)
    for i in range(n):
        s[i] = y[i] + h * (0.02958758547680685 * k0[i] + 0.08876275643042054 * k2[i])
    rates(c, w, t + 0.1183503419072274 * h, s, k3)
    for i in range(n):
        s[i] = y[i] + h * (0.2413651341592667 * k0[i] - 0.8845494793282861 * k2[i] + 0.924834003261792 * k3[i])
    rates(c, w, t + 0.2816496580927726 * h, s, k4)
    for i in range(n):
        s[i] = y[i] + h * (0.037037037037037035 * k0[i] + 0.17082860872947386 * k3[i] + 0.12546768756682242 * k4[i])
    rates(c, w, t + 0.3333333333333333 * h, s, k5)
    for i in range(n):
        s[i] = y[i] + h * (
            0.037109375 * k0[i] + 0.17025221101954405 * k3[i] + 0.06021653898045596 * k4[i] - 0.017578125 * k5[i]
        )
    rates(c, w, t + 0.25 * h, s, k6)
    for i in range(n):
        s[i] = y[i] + h * (
            0.03709200011850479 * k0[i]
            + 0.17038392571223998 * k3[i]
            + 0.10726203044637328 * k4[i]
            - 0.015319437748624402 * k5[i]
            + 0.008273789163814023 * k6[i]
        )
    rates(c, w, t + 0.3076923076923077 * h, s, k7)


def _last_stages(rates: Rates, c: Problem, w: Step, t: float, h: float) -> None:
    """Compute the rates of stages 8 to 11."""
    n = c.size
    y, s = numbers(w.y, n), numbers(w.spare, n)
    k0, k3, k4, k5 = row(w.k, 0, n), row(w.k, 3, n), row(w.k, 4, n), row(w.k, 5, n)
    k6, k7, k8, k9 = row(w.k, 6, n), row(w.k, 7, n), row(w.k, 8, n), row(w.k, 9, n)
    k10, k11 = row(w.k, 10, n), row(w.k, 11, n)
    for i in range(n):
        s[i] = y[i] + h * (
            0.6241109587160757 * k0[i]
            - 3.3608926294469414 * k3[i]
            - 0.868219346841726 * k4[i]
            + 27.59209969944671 * k5[i]
            + 20.154067550477894 * k6[i]
            - 43.48988418106996 * k7[i]
        )
    rates(c, w, t + 0.6512820512820513 * h, s, k8)
    for i in range(n):
        s[i] = y[i] + h * (
            0.47766253643826434 * k0[i]
            - 2.4881146199716677 * k3[i]
            - 0.590290826836843 * k4[i]
            + 21.230051448181193 * k5[i]
            + 15.279233632882423 * k6[i]
            - 33.28821096898486 * k7[i]
            - 0.020331201708508627 * k8[i]
        )
    rates(c, w, t + 0.6 * h, s, k9)
    for i in range(n):
        s[i] = y[i] + h * (
            -0.9371424300859873 * k0[i]
            + 5.186372428844064 * k3[i]
            + 1.0914373489967295 * k4[i]
            - 8.149787010746927 * k5[i]
            - 18.52006565999696 * k6[i]
            + 22.739487099350505 * k7[i]
            + 2.4936055526796523 * k8[i]
            - 3.0467644718982196 * k9[i]
        )
    rates(c, w, t + 0.8571428571428571 * h, s, k10)
    for i in range(n):
        s[i] = y[i] + h * (
            2.273310147516538 * k0[i]
            - 10.53449546673725 * k3[i]
            - 2.0008720582248625 * k4[i]
            - 17.9589318631188 * k5[i]
            + 27.94888452941996 * k6[i]
            - 2.8589982771350235 * k7[i]
            - 8.87285693353063 * k8[i]
            + 12.360567175794303 * k9[i]
            + 0.6433927460157636 * k10[i]
        )
    rates(c, w, t + h, s, k11)


def _end(rates: Rates, c: Problem, w: Step, t: float, h: float) -> None:
    """Compute the state at the end of a step, and its rates."""
    n = c.size
    y, z = numbers(w.y, n), numbers(w.out, n)
    k0, k5, k6, k7 = row(w.k, 0, n), row(w.k, 5, n), row(w.k, 6, n), row(w.k, 7, n)
    k8, k9, k10, k11 = row(w.k, 8, n), row(w.k, 9, n), row(w.k, 10, n), row(w.k, 11, n)
    k12 = row(w.k, 12, n)
    for i in range(n):
        z[i] = y[i] + h * (
            0.054293734116568765 * k0[i]
            + 4.450312892752409 * k5[i]
            + 1.8915178993145003 * k6[i]
            - 5.801203960010585 * k7[i]
            + 0.3111643669578199 * k8[i]
            - 0.1521609496625161 * k9[i]
            + 0.20136540080403034 * k10[i]
            + 0.04471061572777259 * k11[i]
        )
    rates(c, w, t + h, z, k12)


def _error(c: Problem, w: Step, h: float) -> float:
    """Estimate the error of a step from its two embedded formulas, of order 3 and 5."""
    n, norm3, norm5 = c.size, 0.0, 0.0
    y, z = numbers(w.y, n), numbers(w.out, n)
    k0, k5, k6, k7 = row(w.k, 0, n), row(w.k, 5, n), row(w.k, 6, n), row(w.k, 7, n)
    k8, k9, k10, k11 = row(w.k, 8, n), row(w.k, 9, n), row(w.k, 10, n), row(w.k, 11, n)
    for i in range(c.judged):
        scale = 1.0 / (c.tolerance * (1.0 + max(abs(y[i]), abs(z[i]))))
        error3 = scale * (
            -0.18980075407240762 * k0[i]
            + 4.450312892752409 * k5[i]
            + 1.8915178993145003 * k6[i]
            - 5.801203960010585 * k7[i]
            - 0.4226823213237919 * k8[i]
            - 0.1521609496625161 * k9[i]
            + 0.20136540080403034 * k10[i]
            + 0.02265179219836082 * k11[i]
        )
        error5 = scale * (
            0.01312004499419488 * k0[i]
            - 1.2251564463762044 * k5[i]
            - 0.4957589496572502 * k6[i]
            + 1.6643771824549864 * k7[i]
            - 0.35032884874997366 * k8[i]
            + 0.3341791187130175 * k9[i]
            + 0.08192320648511571 * k10[i]
            - 0.022355307863886294 * k11[i]
        )
        norm3, norm5 = norm3 + error3 * error3, norm5 + error5 * error5
    if norm5 == 0.0:
        return 0.0
    return h * norm5 / math.sqrt((norm5 + 0.01 * norm3) * c.judged)


def _weigh(w: Step, n: int, stages: Sequence[int], weights: Sequence[float], to: MutableSequence[float]) -> None:
    """Write the weighted sum of the rates at some stages."""
    k, share = row(w.k, stages[0], n), weights[0]
    for i in range(n):
        to[i] = share * k[i]
    for j in range(1, len(stages)):
        k, share = row(w.k, stages[j], n), weights[j]
        for i in range(n):
            to[i] += share * k[i]


def dense(rates: Rates, c: Problem, w: Step, t: float, h: float) -> None:
    """Compute the coefficients of a step's dense output."""
    n = c.size
    y, s, z = numbers(w.y, n), numbers(w.spare, n), numbers(w.out, n)
    for extra in range(STAGES_WITH_DENSE - STAGES - 1):
        _weigh(w, n, BETWEEN[extra], WEIGHTS_BETWEEN[extra], s)
        for i in range(n):
            s[i] = y[i] + h * s[i]
        rates(c, w, t + PLACES_BETWEEN[extra] * h, s, row(w.k, STAGES + 1 + extra, n))
    k0, k12 = row(w.k, 0, n), row(w.k, STAGES, n)
    d0, d1, d2 = row(w.dense, 0, n), row(w.dense, 1, n), row(w.dense, 2, n)
    for i in range(n):
        change = z[i] - y[i]
        d0[i] = change
        d1[i] = h * k0[i] - change
        d2[i] = 2.0 * change - h * (k12[i] + k0[i])
    for power in range(3, POWERS):
        high = row(w.dense, power, n)
        _weigh(w, n, ALL, HIGH[power - 3], high)
        for i in range(n):
            high[i] = h * high[i]


def value_at(c: Problem, w: Step, component: int, x: float) -> float:
    """One component of the state at the share x of the step, by its dense output."""
    value = 0.0
    for power in range(POWERS - 1, -1, -1):
        value = (value + row(w.dense, power, c.size)[component]) * (x if power % 2 == 0 else 1.0 - x)
    return float(numbers(w.y, c.size)[component] + value)


def rate_at(c: Problem, w: Step, component: int, x: float) -> float:
    """Derivative of `value_at` by x."""
    value = rate = 0.0
    for power in range(POWERS - 1, -1, -1):
        value += row(w.dense, power, c.size)[component]
        if power % 2 == 0:
            rate = rate * x + value
            value *= x
        else:
            rate = rate * (1.0 - x) - value
            value *= 1.0 - x
    return rate


def narrowed(
    happened: Callable[..., bool],
    c: Problem,
    w: Step,
    event: int,
    part: tuple[float, float],
    h: float,
    width: float,
) -> tuple[float, float]:
    """Narrow a part of a step, at whose end an event has happened, by halves until it is no longer than `width`, s.

    Args:
        happened: (c, w, place in the step, h, event): whether it has happened there.
        c: The constants of the motion.
        w: The step.
        event: The event.
        part: Where that part begins and ends.
        h: Unit of these places, s.
        width: Wanted length, s.
    """
    low, high = part
    while (high - low) * h > width:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        if happened(c, w, middle, h, event):
            high = middle
        else:
            low = middle
    return low, high
