"""Which feet may collide with which pieces of the ground: MuJoCo's contact bits against the rule, pair by pair."""

from typing import Any

import golden_numbers
import mujoco
import numpy as np
import pytest
from simulations import started

import mjbiped
from mjbiped.control.controller import Unpowered
from mjbiped.engines.mujoco.collisions import NOBODY, SUNK, write_contact_bits
from mjbiped.robots.robot import Robot
from mjbiped.terrain.profile import height_of, segment_met, segment_stood_on

ROBOTS: dict[str, Robot] = {
    "compass": mjbiped.Compass(),
    "knees": mjbiped.KneedBiped(),
    "pads": mjbiped.FootedCompass(),
    "boxes": mjbiped.FootedCompass(underside="box"),
    "round": mjbiped.RoundCompass(),
    "wheel": mjbiped.RimlessWheel(spokes=6),
}


def may_collide(c: Any, u: Any, leg: int, foot: tuple[float, float], piece: range, riser: bool) -> bool:
    """The rule: whether a leg's foot, as a sphere at a place, collides with a piece of ground, or with a riser.

    The swing foot does, once the scuffing rule lets it, with what it can meet as a point, and so does a foot that has
    just landed. A standing one does with all that does not rise beside it. Of other legs none does, nor a foot that
    lifts off. A box meets all ground but risers; those of robots without the scuffing rule are met while they stand,
    too.
    """
    x, z = foot
    stance, swing, lifts = int(u.stance), int(u.stance + 1) % c.leg_count, u.lifted == leg
    landed = u.time == u.transfer_time and u.count > 0.0
    met = segment_met(c, x, z)
    meets = (met < piece[0]) == (c.rises[piece[0]] > 0.0) if riser else met in piece
    if leg not in (stance, swing) or (leg == swing and not u.collides):
        return False
    if c.box:
        return not (lifts or riser)
    if leg == swing:
        return meets and not lifts
    if landed:
        return meets
    if lifts or riser:
        return not lifts and meets and not c.scuffs
    on = segment_stood_on(c, x, z, SUNK)
    nearest = piece[0] if on < piece[0] else piece[-1]
    return on in piece or height_of(c, nearest, x) <= z + SUNK


def near(c: Any, x: float, z: float) -> dict[int, tuple[range, bool]]:
    """Geoms under a foot and next to it, with the segments that they are, and whether they are risers."""
    found: dict[int, tuple[range, bool]] = {}
    on, met = segment_stood_on(c, x, z, SUNK), segment_met(c, x, z)
    for segment in (on, int(c.firsts[on]) - 1, int(c.lasts[on]) + 1, met):
        if 0 <= segment < c.segments:
            found[int(c.pieces[segment])] = range(int(c.firsts[segment]), int(c.lasts[segment]) + 1), False
    for segment in (met, met + 1):
        if segment < c.segments and c.risers[segment] >= 0.0:
            found[int(c.risers[segment])] = range(segment, segment + 1), True
    return found


def sills_of(c: Any, piece: range) -> list[int]:
    """Geoms that stand for a piece of ground at the foot of its risers."""
    sills = [c.sills[segment] for segment in piece if c.rises[segment] < 0.0]
    sills += [c.sills[after] for after in (s + 1 for s in piece) if after < c.segments and c.rises[after] > 0.0]
    return [int(sill) for sill in sills if sill >= 0.0]


@pytest.mark.parametrize("ground", ["auto", "boxes"])
@pytest.mark.parametrize("name", ROBOTS)
def test_bits_are_the_rule(name: str, ground: str) -> None:
    """Of feet at random places about random segments, above them and in them."""
    if name == "boxes" and ground == "auto":
        pytest.skip("a box stands on boxes")
    random, robot, seen, told = np.random.default_rng(7), ROBOTS[name], [], []
    ranges: Any = {"segment_length": (0.1, 0.5), "slope_deg": (-4.0, 4.0), "rise": (-0.02, 0.02)}
    for seed in range(4):
        terrain = mjbiped.Terrain.random(seed=seed, length=5.0, **ranges)
        simulation = started(Unpowered(), terrain, robot=robot, ground=ground)
        c, u, model, data = simulation.constants, simulation.state, simulation.model, simulation.data
        for _ in range(150):
            u.stance, u.count = float(random.integers(c.leg_count)), float(random.integers(2))
            u.collides, u.lifted = float(random.integers(2)), float(random.integers(-1, c.leg_count))
            if random.integers(2):
                u.lifted = NOBODY
            u.time, u.transfer_time = 1.0, float(random.integers(2))
            data.qpos[:] = random.uniform(-0.3, 0.3, model.nq)
            mujoco.mj_kinematics(model, data)
            chosen = c.legs[(int(u.stance) + int(random.integers(2))) % c.leg_count]
            below, place = data.geom_xpos[chosen.foot].copy(), random.choice(c.x[1:])
            place += random.choice([-1.0, 1.0]) * random.choice([1e-7, 1e-5, 5e-4, 2e-3, 0.05])
            on = min(segment_stood_on(c, place, 0.0) + int(random.integers(-1, 2)), c.segments - 1)
            height = height_of(c, max(on, 0), place) + random.choice([-1e-2, -4e-4, -2e-5, 0.0, 2e-5, 1e-3, 1e-2])
            data.qpos[0] += place - below[0]
            data.qpos[1] += height - below[2]
            mujoco.mj_kinematics(model, data)
            u.q[: model.nq] = data.qpos
            write_contact_bits(c, u)
            told += [*model.geom_contype, *model.geom_conaffinity]
            for number, leg in enumerate(c.legs):
                for foot in (leg.foot, leg.toe):
                    if foot < 0:
                        continue
                    x, _, z = data.geom_xpos[foot].tolist()
                    for geom, (piece, riser) in near(c, x, z).items():
                        both = model.geom_contype, model.geom_conaffinity
                        bits = 0
                        for part in (geom, *([] if riser else sills_of(c, piece))):
                            bits |= int(both[0][foot] & both[1][part]) | int(both[0][part] & both[1][foot])
                        rule = may_collide(c, u, number, (x, z), piece, riser)
                        assert bool(bits) == rule, (seed, number, x, z, piece, riser)
                        seen.append((riser, rule))
    golden_numbers.check(f"bits of {name} on {ground}", {"all": told})
    often = {each for each in set(seen) if seen.count(each) > 50}  # of risers or not, and whether they may collide
    assert often == {(False, False), (False, True), (True, False), *([(True, True)] if name != "boxes" else [])}
