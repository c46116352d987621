"""What no record can be otherwise: feet stand on the ground, and where they stood; angles are those of the posture."""

import numpy as np
import pytest
from engines.conformance.cases import FEET, QUICK, bodies_of, contact_step, parametrised, walk_of
from golden_walks import Case

from mjbiped.terrain.profile import height_of, segment_stood_on

SLIP = 2e-4
"""m. MuJoCo's plain step of length h holds a foot at its beginning: it moves by h l dq^2 / 2 per second, in the 0.8 s
of a fast step with h = 0.1 ms by 0.9e-4 m. A foot that bears a face impact hops."""


@parametrised(QUICK)
def test_feet_stand_on_the_ground(case: Case) -> None:
    walk, bodies = walk_of(case), bodies_of(case.robot)
    rows, samples, robot, profile = walk.touchdowns, walk.samples, walk.robot, walk.terrain.profile
    exact = case.engine == "hybrid"
    struck = bool(rows["strikes"].any())
    number = len(bodies.ends)
    places = [(0.0, walk.terrain.height_at(0.0)), *zip(rows["x"], rows["z"], strict=True)]
    for x, z in places[1:]:
        height = height_of(profile, segment_stood_on(profile, x, z), x)
        assert z == pytest.approx(height, abs=1e-11 if exact else 1.1 * contact_step(case))  # at up to 1.1 m/s
    if not robot.radius:
        for row, (x, z) in enumerate(places[1:]):
            leg = int(rows["stance"][row]) % number
            foot = robot.limbs(rows["qpos"][row])[leg, -1]
            # feet that are bodies are told by their pads or corners in MuJoCo
            assert foot == pytest.approx([x, z], abs=1e-11 if exact else 1e-4)
    on = np.searchsorted(rows["time"], samples["time"] + 1e-12)
    for at in range(0, len(on) - 1, 7):
        step = int(on[at])
        if on[at + 1] != step or (step < walk.steps and rows.get("tipped", rows["time"] * 0)[step] > 1e-3):
            continue
        qpos, leg = samples["qpos"][at], int(samples["stance"][at]) % number
        slope = samples["slope"][at]
        end = bodies.ends[leg].place(qpos) - bodies.radius * 1j * np.exp(-1j * slope)
        if case.robot in FEET:
            end -= robot.foot.height * 1j * np.exp(-1j * slope)  # type: ignore[attr-defined]
        away = end - complex(*places[step])
        # a round foot rolls along the slope
        apart = away * np.exp(1j * slope)
        assert abs(apart.imag) < (1e-9 if exact else SLIP + struck * 0.01), at
        assert bodies.radius or abs(apart.real) < (1e-9 if exact else SLIP + struck * 0.01), at


@parametrised(QUICK)
def test_angles_are_those_of_the_posture(case: Case) -> None:
    walk, bodies = walk_of(case), bodies_of(case.robot)
    samples = walk.samples
    exact = case.engine == "hybrid"
    for at in range(0, len(samples["time"]), 11):
        qpos, leg, slope, q = (samples[name][at] for name in ("qpos", "stance", "slope", "q"))
        hip, leg = complex(qpos[0], qpos[1]), int(leg)
        line = hip - bodies.ends[leg % len(bodies.ends)].place(qpos)
        if bodies.radius and len(q) == 3:
            continue  # the line of a leg with a round foot is that at its stop
        away = np.angle(1j / line * np.exp(-1j * (slope + q[0])))
        # in MuJoCo the lock of a stance knee gives by some 1e-6 rad
        assert away == pytest.approx(0.0, abs=1e-11 if exact else 1e-5), at
    rows = walk.touchdowns
    legs = 2 if len(samples["qpos"][0]) > 3 else len(bodies.ends)
    assert (rows["stance"] % legs == (1 + np.arange(walk.steps)) % legs).all()
    assert (np.diff(rows["time"]) > 0.0).all()
    assert (np.diff(rows["x"]) > 0.0).all()
    for x, z, slope in zip(rows["x"], rows["z"], rows["slope"], strict=True):
        profile = walk.terrain.profile
        assert slope == pytest.approx(walk.terrain.angle[segment_stood_on(profile, x, z)], abs=1e-15 if exact else 1e-4)
