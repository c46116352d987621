"""Robots from a user's MJCF: a compass biped or a biped with knees, recognised by the tree of its bodies."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mjbiped.engines.mujoco.scene import SMALLEST_HIP_MASS, SMALLEST_INERTIA
from mjbiped.errors import InputError, prefixed, shown
from mjbiped.exchange.parts import Part, Vector, check_lossless, compiled, limits_of, parts_of
from mjbiped.robots.bodies import Segment
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.utils.files import require_file

_SAME = 1e-6  # relative; greatest difference of equal legs: files have six digits
_OF_LINKS = ("mass", "length", "centre", "inertia")
_ON_LINE = 1e-6  # leg lengths; farthest place of a centre of mass from its link's line


class Found(NamedTuple):
    """What an MJCF file holds.

    Attributes:
        robot: The robot.
        limits: Greatest torques that the file lets hinges and motors have, N m, by their names.
    """

    robot: Compass | KneedBiped
    limits: dict[str, float]


def read_robot(path: str | Path) -> Compass | KneedBiped:
    """Read a robot from an MJCF file: masses, lengths, inertias and gravity.

    The file's names do not matter. Its moving bodies must be a planar biped of two equal legs, each of one link or of
    two with a knee between them, hinged to each other or to a hip that slides and does not turn. Feet are the spheres,
    or ends of capsules, farthest from the last hinge. Ground, motors, limits and locks are left aside.

    Args:
        path: The file, which MuJoCo must be able to compile; another process does so, within 10 s and 2 GiB.

    Returns:
        The robot. A mass at the hip that is too small for a body in MuJoCo counts as none.

    Raises:
        InputError: The file cannot be read, or holds no such robot; the message says what is missing.
    """
    return read_file(path).robot


def read_file(path: str | Path) -> Found:
    """Read a robot as `read_robot` does, and the limits of its motors, which robots here do not have.

    Raises:
        InputError: See `read_robot`.
    """
    path = Path(path)
    with prefixed(f"{shown(str(path))}: "):
        require_file(path)
        model = compiled(path)
        robot = _robot_of(parts_of(model), float(np.linalg.norm(model.opt.gravity)))
        check_lossless(model)
        return Found(robot, limits_of(model))


def _robot_of(parts: Sequence[Part], gravity: float) -> Compass | KneedBiped:
    """Recognise a robot in the parts of a model.

    Raises:
        InputError: Its legs are not equal.
    """
    hip_mass, legs = _legs_of(parts)
    unequal = _difference(*legs)
    if unequal:  # a point mass at the hip may be welded to the heavier one
        light, heavy = sorted(legs, key=lambda leg: leg[0].mass)
        top, mass = heavy[0], light[0].mass
        centre = top.mass / mass * top.centre
        inertia = top.inertia + top.mass * top.centre**2 - mass * centre**2
        if _difference(light, [top._replace(mass=mass, centre=centre, inertia=inertia), *heavy[1:]]):
            raise InputError(f"its legs are not equal: {unequal}")
        hip_mass, legs = hip_mass + top.mass - mass, (light, light)
    links = legs[0]
    total, length = hip_mass + 2.0 * sum(link.mass for link in links), sum(link.length for link in links)
    if hip_mass <= (1.0 + _SAME) * SMALLEST_HIP_MASS * total:
        hip_mass = 0.0
    least = (1.0 + _SAME) * SMALLEST_INERTIA * length**2
    links = [link._replace(inertia=link.inertia * (link.inertia > least * link.mass)) for link in links]
    if len(links) == 1:
        (leg,) = links
        return Compass(leg.mass, hip_mass, leg.length - leg.centre, leg.centre, leg.inertia, gravity)
    named = zip(("thigh", "shank"), links, strict=True)
    own = {f"{part}_{name}": getattr(link, name) for part, link in named for name in _OF_LINKS}
    return KneedBiped(**own, hip_mass=hip_mass, gravity=gravity)


def _difference(one: Sequence[Segment], other: Sequence[Segment]) -> str:
    """Say in which number two legs differ; empty if they are equal."""
    scale = sum(link.length for link in one)
    for ours, theirs in zip(one, other, strict=True):
        units = (ours.mass, scale, scale, ours.mass * scale**2)
        for name, unit in zip(_OF_LINKS, units, strict=True):
            first, second = getattr(ours, name), getattr(theirs, name)
            if abs(first - second) > _SAME * unit:
                return f"{name} {first:.6g} of {ours.name}, and {second:.6g} of {theirs.name}"
    return ""


def _legs_of(parts: Sequence[Part]) -> tuple[float, tuple[list[Segment], list[Segment]]]:
    """Find the hip, and return the mass of a body that slides there, kg, and both legs from the hip down.

    Raises:
        InputError: There is no hip between two legs of one or two links each.
    """
    roots = [part for part in parts if part.parent < 0]
    if len(roots) != 1:
        told = " and ".join(root.name for root in roots)
        raise InputError(f"{told} hang on the world apart; expected one body that carries all others")
    chain = _chain_of(parts)
    half, odd = divmod(len(chain), 2)
    middle = parts[chain[half]]
    if odd and middle.turns:
        raise InputError(
            f"{middle.name} turns between the legs; expected no trunk: let the hip slide without a hinge, or hinge the "
            "legs to each other"
        )
    if len(chain) > 4 + odd or not (odd or roots[0].turns):
        told = ", ".join(parts[number].name for number in chain)
        raise InputError(
            f"from foot to foot it has {told}; expected one link each, or a thigh and a shank, and between the legs a "
            "hip or nothing: weld other links"
        )
    (hip, one), (other_hip, other) = _leg(parts, chain[half::-1]), _leg(parts, chain[half + odd - 1 :])
    if np.linalg.norm(hip - other_hip) > _SAME:
        raise InputError(f"{one[0].name} and {other[0].name} have hinges apart; expected one hip for both legs")
    return middle.mass * odd, (one, other)


def _chain_of(parts: Sequence[Part]) -> list[int]:
    """Return the numbers of all parts from one foot to the other.

    Raises:
        InputError: The parts are not a chain.
    """
    if len(parts) < 2:
        raise InputError(f"only {parts[0].name} moves; expected two legs with a hinge between them")
    hinged = [{k for k, part in enumerate(parts) if part.parent == number} for number in range(len(parts))]
    for number, part in enumerate(parts):
        hinged[number] |= {part.parent} - {-1}
        if len(hinged[number]) > 2:
            raise InputError(f"{part.name} carries more than one leg beside its own; expected two legs in all")
    chain = [next(number for number, beside in enumerate(hinged) if len(beside) == 1)]
    while following := hinged[chain[-1]] - set(chain):
        chain += following
    return chain


def _leg(parts: Sequence[Part], chain: Sequence[int]) -> tuple[Vector, list[Segment]]:
    """Return the place of the hip and the links of a leg as the robots here have them.

    Args:
        parts: All parts.
        chain: Numbers of what is above the leg, and of its links from the hip down.

    Raises:
        InputError: The leg has no foot, or the centre of mass of a link does not lie on it.
    """
    hinges = [parts[max(pair)].anchor for pair in pairwise(chain)]  # parents stand first
    last, links = parts[chain[-1]], list[Segment]()
    if not last.ends:
        raise InputError(
            f"{last.name} has no foot; expected a sphere or a capsule that can touch something (contype or "
            "conaffinity), with its end where the foot stands"
        )
    foot = max(last.ends, key=lambda end: float(np.linalg.norm(end - hinges[-1])))
    for number, (upper, lower) in zip(chain[1:], pairwise([*hinges, foot]), strict=True):
        part, length = parts[number], float(np.linalg.norm(lower - upper))
        if not length:
            raise InputError(f"{part.name} has no length; expected a foot or a knee apart from the hinge above it")
        along, (x, z) = (lower - upper) / length, part.centre - upper
        centre, beside = float(along @ (x, z)), abs(float(along[0] * z - along[1] * x))
        if beside > _ON_LINE * length or not 0.0 <= centre <= length:
            raise InputError(
                f"the centre of mass of {part.name} lies {beside:.3g} m beside the line from its hinge to its lower "
                f"end, {centre:.3g} m along it; expected 0 m, and 0 to {length:.3g} m"
            )
        links.append(Segment(part.name, part.mass, length, centre, part.inertia))
    return hinges[0], links
