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
from collections.abc import Callable, MutableSequence
from typing import Protocol, TypeAlias

import numpy as np

from mjbiped.numerics.blocks import Floats, numbers, row

Rates: TypeAlias = Callable[..., None]

STAGES = 12  # of a step; the rates at its end are stage 12, the next step's stage 0
STAGES_WITH_DENSE = 16
POWERS = 7  # of the dense output
IN_ORDER = (0, 6, 7, 5, 9, 8, 10, 12)
"""Stages in the order of their places, without those whose states lie beside the motion: up to 2e-3 of the torque."""

PLACES = (0.0, 0.25, 0.3076923076923077, 0.3333333333333333, 0.6, 0.6512820512820513, 0.8571428571428571, 1.0)
"""Where these stages lie, in shares of the step."""

SHARES = np.array(
    (0.05260015195876773, 0.0789002279381516, 0.1183503419072274, 0.2816496580927726, 0.3333333333333333, 0.25,
     0.3076923076923077, 0.6512820512820513, 0.6, 0.8571428571428571, 1.0, 1.0, 0.1, 0.2, 0.7777777777777778)
)  # fmt: skip
"""Where stages 1 to 15 lie, in shares of the step; stage 12 is its end."""

ROWS: tuple[tuple[tuple[int, ...], tuple[float, ...]], ...] = (
    ((0,),
     (0.05260015195876773,)),
    ((0, 1),
     (0.0197250569845379, 0.0591751709536137)),
    ((0, 2),
     (0.02958758547680685, 0.08876275643042054)),
    ((0, 2, 3),
     (0.2413651341592667, -0.8845494793282861, 0.924834003261792)),
    ((0, 3, 4),
     (0.037037037037037035, 0.17082860872947386, 0.12546768756682242)),
    ((0, 3, 4, 5),
     (0.037109375, 0.17025221101954405, 0.06021653898045596, -0.017578125)),
    ((0, 3, 4, 5, 6),
     (0.03709200011850479, 0.17038392571223998, 0.10726203044637328, -0.015319437748624402, 0.008273789163814023)),
    ((0, 3, 4, 5, 6, 7),
     (0.6241109587160757, -3.3608926294469414, -0.868219346841726, 27.59209969944671, 20.154067550477894,
      -43.48988418106996)),
    ((0, 3, 4, 5, 6, 7, 8),
     (0.47766253643826434, -2.4881146199716677, -0.590290826836843, 21.230051448181193, 15.279233632882423,
      -33.28821096898486, -0.020331201708508627)),
    ((0, 3, 4, 5, 6, 7, 8, 9),
     (-0.9371424300859873, 5.186372428844064, 1.0914373489967295, -8.149787010746927, -18.52006565999696,
      22.739487099350505, 2.4936055526796523, -3.0467644718982196)),
    ((0, 3, 4, 5, 6, 7, 8, 9, 10),
     (2.273310147516538, -10.53449546673725, -2.0008720582248625, -17.9589318631188, 27.94888452941996,
      -2.8589982771350235, -8.87285693353063, 12.360567175794303, 0.6433927460157636)),
    ((0, 5, 6, 7, 8, 9, 10, 11),
     (0.054293734116568765, 4.450312892752409, 1.8915178993145003, -5.801203960010585, 0.3111643669578199,
      -0.1521609496625161, 0.20136540080403034, 0.04471061572777259)),
    ((0, 6, 7, 8, 9, 10, 11, 12),
     (0.056167502283047954, 0.25350021021662483, -0.2462390374708025, -0.12419142326381637, 0.15329179827876568,
      0.00820105229563469, 0.007567897660545699, -0.008298)),
    ((0, 5, 6, 7, 10, 11, 12, 13),
     (0.03183464816350214, 0.028300909672366776, 0.053541988307438566, -0.05492374857139099,
      -0.00010834732869724932, 0.0003825710908356584, -0.00034046500868740456, 0.1413124436746325)),
    ((0, 5, 6, 7, 8, 12, 13, 14),
     (-0.42889630158379194, -4.697621415361164, 7.683421196062599, 4.06898981839711, 0.3567271874552811,
      -0.0013990241651590145, 2.9475147891527724, -9.15095847217987)),
    ((0, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15),
     (-8.428938276109013, 0.5667149535193777, -3.0689499459498917, 2.38466765651207, 2.117034582445028,
      -0.871391583777973, 2.2404374302607883, 0.6315787787694688, -0.08899033645133331, 18.148505520854727,
      -9.194632392478356, -4.436036387594894)),
    ((0, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15),
     (10.427508642579134, 242.28349177525817, 165.20045171727028, -374.5467547226902, -22.113666853125306,
      7.733432668472264, -30.674084731089398, -9.332130526430229, 15.697238121770845, -31.139403219565178,
      -9.35292435884448, 35.81684148639408)),
    ((0, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15),
     (19.985053242002433, -387.0373087493518, -189.17813819516758, 527.8081592054236, -11.57390253995963,
      6.8812326946963, -1.0006050966910838, 0.7777137798053443, -2.778205752353508, -60.19669523126412,
      84.32040550667716, 11.99229113618279)),
    ((0, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15),
     (-25.69393346270375, -154.18974869023643, -231.5293791760455, 357.6391179106141, 93.40532418362432,
      -37.45832313645163, 104.0996495089623, 29.8402934266605, -43.53345659001114, 96.32455395918828,
      -39.17726167561544, -149.72683625798564)),
    ((0, 5, 6, 7, 8, 9, 10, 11),
     (-0.18980075407240762, 4.450312892752409, 1.8915178993145003, -5.801203960010585, -0.4226823213237919,
      -0.1521609496625161, 0.20136540080403034, 0.02265179219836082)),
    ((0, 5, 6, 7, 8, 9, 10, 11),
     (0.01312004499419488, -1.2251564463762044, -0.4957589496572502, 1.6643771824549864, -0.35032884874997366,
      0.3341791187130175, 0.08192320648511571, -0.022355307863886294)),
)  # fmt: skip
"""Sums of rates over the stages, as (stages, weights): for the state of stages 1 to 11, of the step's end, and of the
three stages between; for the dense output's coefficients from the third power on; for the errors of order 3 and 5."""

FROM = np.array([stage for stages, _ in ROWS for stage in stages])
WEIGHTS = np.array([weight for _, weights in ROWS for weight in weights])
BEGINS = np.cumsum([0, *(len(stages) for stages, _ in ROWS)])
ERRORS = len(ROWS) - 2


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
    for stage in range(1, STAGES + 1):
        _take_rates(rates, c, w, t, h, stage)
    n, norm3, norm5 = c.size, 0.0, 0.0
    y, z, third, fifth = numbers(w.y, n), numbers(w.out, n), row(w.dense, 0, n), row(w.dense, 1, n)
    _weigh(w, n, ERRORS, third)
    _weigh(w, n, ERRORS + 1, fifth)
    for i in range(c.judged):
        scale = 1.0 / (c.tolerance * (1.0 + max(abs(y[i]), abs(z[i]))))
        error3, error5 = scale * third[i], scale * fifth[i]
        norm3, norm5 = norm3 + error3 * error3, norm5 + error5 * error5
    if norm5 == 0.0 and norm3 == 0.0:
        return 0.0
    return h * norm5 / math.sqrt((norm5 + 0.01 * norm3) * c.judged)


def _take_rates(rates: Rates, c: Problem, w: Step, t: float, h: float, stage: int) -> None:
    """Compute the rates of a stage, and its state: in `w.out` that of the step's end, in `w.spare` all others."""
    n = c.size
    y, z = numbers(w.y, n), numbers(w.out if stage == STAGES else w.spare, n)
    _weigh(w, n, stage - 1, z)
    for i in range(n):
        z[i] = y[i] + h * z[i]
    rates(c, w, t + float(SHARES[stage - 1]) * h, z, row(w.k, stage, n))


def _weigh(w: Step, n: int, which: int, to: MutableSequence[float]) -> None:
    """Write one of the weighted sums of rates."""
    begin, end = int(BEGINS[which]), int(BEGINS[which + 1])
    k, share = row(w.k, int(FROM[begin]), n), float(WEIGHTS[begin])
    for i in range(n):
        to[i] = share * k[i]
    for j in range(begin + 1, end):
        k, share = row(w.k, int(FROM[j]), n), float(WEIGHTS[j])
        for i in range(n):
            to[i] += share * k[i]


def dense(rates: Rates, c: Problem, w: Step, t: float, h: float) -> None:
    """Compute the coefficients of a step's dense output."""
    n = c.size
    y, z = numbers(w.y, n), numbers(w.out, n)
    for stage in range(STAGES + 1, STAGES_WITH_DENSE):
        _take_rates(rates, c, w, t, h, stage)
    k0, k12 = row(w.k, 0, n), row(w.k, STAGES, n)
    d0, d1, d2 = row(w.dense, 0, n), row(w.dense, 1, n), row(w.dense, 2, n)
    for i in range(n):
        change = z[i] - y[i]
        d0[i] = change
        d1[i] = h * k0[i] - change
        d2[i] = 2.0 * change - h * (k12[i] + k0[i])
    for power in range(3, POWERS):
        high = row(w.dense, power, n)
        _weigh(w, n, STAGES_WITH_DENSE - 4 + power, high)
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
