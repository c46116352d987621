"""What stands beside a study's axes."""

from __future__ import annotations

from typing import Any

from mjbiped.records.measures import measures_of
from mjbiped.robots.kneed import KneedBiped
from mjbiped.sweeps.plan import FINISHED

_WITH_UNIT = {
    "m": ("lower_length", "upper_length", "distance", "length", "tread", "rise", "first", "segment_length", "roughness",
          "spacing", "thigh_length", "shank_length", "thigh_centre", "shank_centre"),
    "s": ("timestep", "contact_timestep", "control_period", "delay", "push_interval", "push_duration"),
    "rad": ("q1", "q2", "q3", "angle_noise", "angle_bias", "angle_resolution"),
    "rad/s": ("dq1", "dq2", "dq3", "rate_noise", "rate_bias"),
    "N m": ("torque_limit",),
    "N s": ("push_impulse",),
    "Hz": ("motor_bandwidth",),
    "kg": ("leg_mass", "hip_mass", "thigh_mass", "shank_mass"),
    "kg m²": ("leg_inertia", "thigh_inertia", "shank_inertia"),
    "m/s²": ("gravity",),
    "1/s": ("position_gain", "velocity_gain"),
}  # fmt: skip
_IN_WORDS = {".plus_minus": ", ±", ".low": ", low end", ".high": ", high end", "_deg": "", ".": " ", "_": " "}
"""Parts of a dotted name, in the order in which they are replaced."""

_UNITS = {name: unit for unit, names in _WITH_UNIT.items() for name in names}
_MEASURES = {key: (label, factor, unit) for label, key, factor, _, unit in measures_of(KneedBiped)}


def parameter_label(name: str) -> str:
    """A varied quantity in words, with its unit."""
    words = name.removesuffix(".name")
    for part, said in _IN_WORDS.items():
        words = words.replace(part, said)
    units = [_UNITS[part] for part in name.split(".") if part in _UNITS]
    unit = "°" if "_deg" in name else (units or [""])[0]
    return f"{words} ({unit})" if unit else words


def measure_label(name: str) -> str:
    """A measure in words, with its unit."""
    if name == FINISHED:
        return "share that finished"
    label, _, unit = _MEASURES.get(name, (name.replace("_", " "), 1.0, ""))
    units = {"largest_impact_error": "", "largest_slip_m": "m", "largest_penetration_m": "m"}  # shown scaled elsewhere
    unit = units.get(name, unit)
    return f"{label} ({unit})" if unit else label


def value_label(name: str, value: Any) -> str:
    """A value that tells groups apart: names speak for themselves, others come with what they are of."""
    if name == "engine" or name.endswith((".name", ".file", ".kind")):
        return str(value)
    return f"{name.rpartition('.')[2].replace('_', ' ')} {value}"
