"""Numbers that others have published about walkers which this laboratory can simulate, digit by digit as printed.

Each stands here once, with its source, and with its fault where it has one. `python -m scripts.validation.page`
computes them again and writes docs/tables/validation.md; `tests/scripts/validation` holds them. The tables of the paper
that this project implements stand in `mjbiped.reproduction.grounds`.

Angles and rates keep the signs and the names that they have in their source.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.round import RoundCompass
from mjbiped.robots.round_kneed import RoundKneed


@dataclass(frozen=True)
class Published:
    """A number as it was printed.

    Attributes:
        quantity: What it is, with its unit.
        printed: Its digits; of a pair of conjugate numbers the one above the real axis, as "0.1 + 0.2i".
        place: Where it stands in its source.
        claimed: How exact its source calls it; None: no word about it.
        fault: What is wrong with it; empty where it is right.
    """

    quantity: str
    printed: str
    place: str
    claimed: float | None = None
    fault: str = ""

    @property
    def value(self) -> complex:
        """The number."""
        return complex(self.printed.replace(" ", "").replace("i", "j"))

    @property
    def decimals(self) -> int:
        """Digits printed after the point."""
        return len(self.printed.rstrip("i").rpartition(".")[2])

    @property
    def tolerance(self) -> float:
        """How far the true number may lie from it: what its source claims, or half a unit of each last digit."""
        half = 0.5 * 10.0**-self.decimals
        return (abs(complex(half, half)) if self.value.imag else half) if self.claimed is None else self.claimed


GARCIA_SLOPE = 0.009
"""Of the gaits of the simplest walker, rad."""

GARCIA_ROBOT = Compass(leg_mass=1e-9, hip_mass=1e3, lower_length=1e-9, upper_length=1e3, leg_inertia=0.0, gravity=1e3)
"""The simplest walker: massless legs with their mass at the feet, but for 1e-12 of the hip's mass and of the length.

Its unit of time, sqrt(l/g), is 1 s.
"""

_PROGRAM = "comment in M. Garcia's program"
_APPENDIX = "table in appendix A.2"
_FORWARD = "a difference quotient: one-sided, of width 1e-5"

GARCIA: Mapping[str, Published] = {
    "long angle": Published("long gait: θ", "0.20031090049483", _PROGRAM, 1e-10),
    "long rate": Published("long gait: θ̇", "-0.19983247291764", _PROGRAM, 1e-10),
    "long pair": Published(
        "long gait: pair of multipliers", "-0.19120868949940 + 0.55633363687106i", _PROGRAM, fault=_FORWARD
    ),
    "short angle": Published(
        "short gait: θ", "0.19393736960624", _PROGRAM, 1e-10, fault="good to 2.1e-10, not to the 1e-10 claimed"
    ),
    "short rate": Published(
        "short gait: θ̇", "-0.20386692731962", _PROGRAM, 1e-10, fault="good to 1.3e-10, not to the 1e-10 claimed"
    ),
    "short first": Published("short gait: first multiplier", "4.000", _PROGRAM, fault=_FORWARD),
    "short second": Published("short gait: second multiplier", "0.459", _PROGRAM, fault=_FORWARD),
    "doubling": Published("slope of the first doubling, rad", "0.0151", "section 5.1; 0.015 in the abstract"),
    "lost": Published("slope beyond which nothing walks, rad", "0.019", "section 5.3"),
    "long tau0": Published("long gait: τ₀", "3.812092", _APPENDIX),
    "long tau1": Published("long gait: τ₁", "1.579129", _APPENDIX),
    "long Theta0": Published("long gait: Θ₀", "0.970956", _APPENDIX),
    "long Theta1": Published("long gait: Θ₁", "-0.270837", _APPENDIX, fault="contradicts α and c₁ of its own table"),
    "long alpha": Published("long gait: α", "-1.045203", _APPENDIX),
    "long c1": Published("long gait: c₁", "1.062895", _APPENDIX),
    "short tau0": Published("short gait: τ₀, printed as π", f"{math.pi:.6f}", _APPENDIX),
    "short tau1": Published("short gait: τ₁", "-0.907496", _APPENDIX),
    "short Theta0": Published("short gait: Θ₀", "0.943976", _APPENDIX),
    "short Theta1": Published("short gait: Θ₁", "-0.264561", _APPENDIX),
    "short alpha": Published("short gait: α", "-1.090331", _APPENDIX),
    "short c1": Published("short gait: c₁", "0.866610", _APPENDIX),
}
"""M. Garcia, A. Chatterjee, A. Ruina, M. Coleman 1998, The simplest walking model: stability, complexity, and scaling.

Journal of Biomechanical Engineering 120, 281-288. On a gentle slope γ the gaits are θ = Θ₀ γ^(1/3) + Θ₁ γ,
θ̇ = α Θ₀ γ^(1/3) + (α Θ₁ + c₁) γ, and the period is τ₀ + τ₁ γ^(2/3).
"""

BHOUNSULE: Mapping[str, Published] = {
    "long angle": Published("long gait: θ", "0.200310900563820", "program of 2013", 1e-10),
    "long rate": Published("long gait: θ̇", "-0.199832473025474", "program of 2013", 1e-10),
    "long period": Published("long gait: period", "3.882", "program of 2013"),
    "long modulus": Published("long gait: modulus of the multipliers", "0.58911", "paper of 2014"),
    "short angle": Published("short gait: θ", "0.193937369810188", "program of 2013", 1e-10),
    "short rate": Published("short gait: θ̇", "-0.203866927442012", "program of 2013", 1e-10),
    "short period": Published("short gait: period", "3.096", "program of 2013"),
}
"""P. A. Bhounsule 2014, Numerical accuracy of two benchmark models of walking.

Dynamics of Continuous, Discrete and Impulsive Systems B 21, 137-148, and the program `simplestwalker.m` for it. The
same walker on the same slope; the accuracy is that of Garcia's numbers, for the program names none.
"""

GOSWAMI_SLOPE = math.radians(3.0)
GOSWAMI_ROBOT = Compass(leg_mass=5.0, hip_mass=10.0, lower_length=0.5, upper_length=0.5, leg_inertia=0.0)
"""Point masses on the legs. The report has no number for gravity."""

_QUOTED = "as others give it; the report has curves"
_TWO_STEPS = "of two steps, though not said so, and not to its digits"

GOSWAMI: Mapping[str, Published] = {
    "period": Published("period, s", "0.734", _QUOTED),
    "angle": Published("half the angle between the legs, rad", "0.2710", _QUOTED),
    "stance rate": Published("rate of the stance leg, rad/s", "1.0924", _QUOTED),
    "swing rate": Published("rate of the swing leg, rad/s", "0.3774", _QUOTED),
    "pair": Published("modulus of the pair of multipliers", "0.332", "equation (3.44)", fault=_TWO_STEPS),
    "real": Published("modulus of the third", "0.014", "equation (3.44)", fault=_TWO_STEPS),
    "first doubling": Published(
        "period 2 from, degrees", "4.37", "section 4.2.1", fault="too small; how it was found is not known"
    ),
    "second doubling": Published("period 4 from, degrees", "4.9", "section 4.2.4"),
    "third doubling": Published("period 8 from, degrees", "5.01", "section 4.2.4"),
    "no period": Published("no period found from, degrees", "5.04", "section 4.2.5"),
}
"""A. Goswami, B. Thuilot, B. Espiau 1996, Compass-like biped robot, part I: stability and bifurcation of passive gaits.

INRIA, research report 2996. The gait on 3 degrees, its state just after the impact, and the cascade.
"""

GOSWAMI_CHAOS = math.radians(5.2)
"""Slope whose gait the report calls chaotic, section 4.2.5."""

HSU_CHEN_SLOPE = math.asin(7.25 / 144)
HSU_CHEN_ROBOT = KneedBiped(0.5, 0.05, 0.5, 0.5, 0.5, 0.325, 0.125, 0.0, 0.0, gravity=9.8)
HSU_CHEN_SECOND = KneedBiped(0.5, 0.125, 0.5, 0.5, 0.5, 0.325, 0.125, 0.0, 0.0, gravity=9.8)
"""The same with heavier shanks."""

_TEDRAKE = "kneedCompassGait.m; the thesis, section 3.3, has four digits"
_COMMENT = "comment in kneedCompassGait.m"
_EULER = "of explicit Euler steps of 1 ms"
_FIT = "a fit to 25 disturbed runs"

HSU_CHEN: Mapping[str, Published] = {
    "stance angle": Published("stance leg, rad", "0.187700106303669", _TEDRAKE, fault=_EULER),
    "swing angle": Published("swing leg, rad", "-0.288437140111164", _TEDRAKE, fault=_EULER),
    "stance rate": Published("its rate, rad/s", "-1.101439041094875", _TEDRAKE, fault=_EULER),
    "swing rate": Published("its rate, rad/s", "-0.039885255927632", _TEDRAKE, fault=_EULER),
    "pair": Published("pair of multipliers", "-0.2129 + 0.3454i", "section 3.3.1", fault=_FIT),
    "real": Published("real multiplier", "0.4053", "section 3.3.1", fault=_FIT),
    "second stance angle": Published("second robot: stance leg, rad", "0.189123463312659", _COMMENT, fault=_EULER),
    "second swing angle": Published(
        "second robot: swing leg, rad", "-0.289860497120154", _COMMENT, fault=f"{_EULER}; the thigh's lacks its sign"
    ),
    "second stance rate": Published("second robot: its rate, rad/s", "-1.114780229929899", _COMMENT, fault=_EULER),
    "second swing rate": Published("second robot: its rate, rad/s", "-0.257668352979864", _COMMENT, fault=_EULER),
}
"""V. F. Hsu Chen 2007, Passive dynamic walking with knees: a point foot model (thesis, MIT).

With R. Tedrake's program for it. Just after the heel strike; angles from the vertical, counterclockwise positive.
"""

DRAKE_SLOPE = 0.0525
DRAKE_ROBOT = Compass(leg_mass=5.0, hip_mass=10.0, lower_length=0.5, upper_length=0.5, leg_inertia=0.0, gravity=9.81)
"""Drake's default `CompassGait`."""

DRAKE: Mapping[str, float] = {"statics": 1e-15, "guard": 1e-16, "angular momentum": 5e-15}
"""Tolerances of `compass_gait_test.cc` in Drake, for those of its invariants that need no symbolic algebra.

Acceleration of the posture that a hip torque holds at rest, rad/s^2; height of the foot at touchdown, m; angular
momentum about the struck point, kg m^2/s.
"""

MCGEER_ROBOT = RoundCompass(
    *(0.5, 0.0), lower_length=0.63, upper_length=0.37, foot_radius=0.3, leg_inertia=0.5 * 0.32**2, gravity=1.0
)
MCGEER_SLOPE = 0.0278547
"""In units of the leg's length, the robot's mass, and gravity; the slope, in rad, is that of half angles of 0.3."""

MCGEER: Mapping[str, Published] = {
    "half angle": Published("half of the angle between the legs at the heel strike", "0.3", "radius 0.3", 5e-7),
    "period": Published("period", "2.63152", "there"),
    "multiplier": Published("multiplier", "0.4557", "there"),
    "pair": Published("multipliers, the pair", "-0.1520 + 0.2939i", "there"),
}
"""T. McGeer 1990, Passive dynamic walking, International Journal of Robotics Research 9(2), 62-82.

The machine with feet of 0.3 leg lengths, centre of mass 0.63 above the ground, radius of gyration 0.32, and no mass at
the hip; its numbers are as an independent program gives them to these digits, for the paper has two.
"""

MCGEER_KNEED_ROBOT = RoundKneed(
    *(0.1, 0.062, 0.676),
    *(0.46, 0.54),
    *(0.20, 0.24),
    shank_offset=-0.01,
    stop_angle=0.2,
    foot_radius=0.2,
    thigh_inertia=0.1 * 0.135**2,
    shank_inertia=0.062 * 0.186**2,
    gravity=1.0,
)
MCGEER_KNEED_SLOPE = 0.0456

_KNEED = "Passive walking with knees"
MCGEER_KNEED: Mapping[str, Published] = {
    "modulus": Published("modulus of the pair of multipliers", "0.447", _KNEED, 0.037),
    "angle": Published("its angle, rad", "0.947", _KNEED, 0.15),
    "real": Published("multiplier", "0.073", _KNEED, 0.010),
    "least": Published(
        "least multiplier",
        "-0.001",
        _KNEED,
        0.0005,
        fault="before a heel strike both legs are straight, and three numbers tell the state: the fourth one is 0",
    ),
}
"""T. McGeer 1990, Passive walking with knees, IEEE International Conference on Robotics and Automation.

Its parameters have one to three digits, and no more is known of the numbers than these allow. The most sensitive is the
offset 0.01 of the shank's centre of mass: a change by 0.001, a fifth of half a unit of its only digit, moves modulus,
angle and multiplier by 0.037, 0.15 and 0.010 or more.
"""

ROUND_FEET_ROBOT = RoundCompass(
    *(0.5, 1.0), lower_length=0.7, upper_length=0.5, foot_radius=0.2, leg_inertia=0.02, gravity=1.0
)
ROUND_FEET_SLOPE = 0.01

_MENDED = "the program, its impact mended"
ROUND_FEET: Mapping[str, Published] = {
    "angle": Published("q1", "0.18943828", _MENDED),
    "rate": Published("u1", "-0.23901099", _MENDED),
    "hip angle": Published("q2", "0.37887657", _MENDED),
    "hip rate": Published("u2", "-0.05139701", _MENDED),
    "period": Published("period", "2.427956", _MENDED),
    "multiplier": Published("multiplier", "0.43344", _MENDED),
    "pair": Published("multipliers, the pair", "0.37047 + 0.18370i", _MENDED),
    "program's angle": Published(
        "q1",
        "0.189472782",
        "the program as it is",
        fault="its impact takes I u2 from the trailing leg's angular momentum about the hip, which is conserved",
    ),
}
"""P. A. Bhounsule 2009, the program `passivewalker.m`, second case: legs of mass 0.5 and inertia 0.02 with feet of 0.2,
whose centres are 1 below the hip, and mass 1 there, on 0.01 rad."""
