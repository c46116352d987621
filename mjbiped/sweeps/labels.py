"""What stands beside a study's axes."""

from __future__ import annotations

from typing import Any

from mjbiped.records.measures import MEASURES
from mjbiped.sweeps.plan import FINISHED

_UNITS = {
    "position_gain": "1/s",
    "velocity_gain": "1/s",
    "leg_mass": "kg",
    "hip_mass": "kg",
    "lower_length": "m",
    "upper_length": "m",
    "leg_inertia": "kg m²",
    "gravity": "m/s²",
    "distance": "m",
    "timestep": "s",
    "contact_timestep": "s",
    "length": "m",
    "tread": "m",
    "rise": "m",
    "first": "m",
    "segment_length": "m",
    "roughness": "m",
    "spacing": "m",
    "q1": "rad",
    "q2": "rad",
    "dq1": "rad/s",
    "dq2": "rad/s",
}
_MEASURES = {key: (label, factor, unit) for label, key, factor, _, unit in MEASURES}


def parameter_label(name: str) -> str:
    """A varied quantity in words, with its unit."""
    words = (
        name.removesuffix(".name")
        .replace(".plus_minus", ", ±")
        .replace(".low", ", low end")
        .replace(".high", ", high end")
    )
    units = [_UNITS[part] for part in name.split(".") if part in _UNITS]
    unit = "°" if "_deg" in name else (units or [""])[0]
    words = words.replace("_deg", "").replace(".", " ").replace("_", " ")
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
    if name == "engine" or name.endswith((".name", ".file")):
        return str(value)
    return f"{name.rpartition('.')[2].replace('_', ' ')} {value}"
