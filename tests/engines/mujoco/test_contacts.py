"""What a foot feels, from readings of contact sensors: forces as vectors, and the friction that they ask for."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mjbiped.engines.mujoco.feet import Felt, felt, friction_ratio

forces = st.tuples(st.floats(0.0, 300.0), st.floats(-200.0, 200.0))
slots = st.lists(st.tuples(st.booleans(), st.floats(-0.7, 0.7), forces, st.floats(-1e-3, 1e-3)), min_size=1, max_size=3)


def reading(found: bool, tilt: float, force: tuple[float, float], distance: float) -> list[float]:
    """A slot as MuJoCo fills it: force in the contact's frame, of which the lateral axis is the second."""
    normal = [math.sin(tilt), 0.0, -math.cos(tilt)]
    return [float(found), force[0], 17.0, force[1], distance, 0.0, 0.0, 0.0, *normal]


def felt_in(readings: list[float], before: int = 0, q: tuple[float, float] = (0.0, 0.0), sole: int = -1) -> Felt:
    """What a foot under a straight leg feels whose readings begin behind others."""
    leg: Any = SimpleNamespace(contacts=before, hip=2, knee=-1, sole=sole, offset=0.0, turn=0.0, upper=0.0, height=0.0)
    c: Any = SimpleNamespace(slots=len(readings) - before)
    u: Any = SimpleNamespace(q=[*q, 0.0, 0.0])
    return felt(c, u, readings, leg)


@given(slots, st.integers(0, 3))
@settings(deadline=None, derandomize=True)
def test_forces_of_all_contacts_are_added_as_vectors(
    contacts: list[tuple[bool, float, tuple[float, float], float]], before: int
) -> None:
    """The third axis of a contact's frame is the cross product of the other two: the normal and the lateral axis."""
    readings = [9.0] * before + [number for contact in contacts for number in reading(*contact)]
    found = felt_in(readings, before)
    touching = [contact for contact in contacts if contact[0]]
    total = np.zeros(3)
    for _, tilt, (pressed, rubbed), _ in touching:
        normal = np.array([math.sin(tilt), 0.0, -math.cos(tilt)])
        total += pressed * normal + rubbed * np.cross(normal, [0.0, 1.0, 0.0])
    assert [found.forward, -found.downward] == pytest.approx(total[[0, 2]].tolist(), abs=1e-12 * 1e3)
    assert found.pressure == pytest.approx(sum(contact[2][0] for contact in touching))
    assert found.depth == max([0.0, *(-contact[3] for contact in touching)])
    assert (found.ground, found.face) == (bool(touching), False)


def test_a_face_presses_and_is_no_ground() -> None:
    """Its forces are none of the ground's, and its depth neither."""
    face = reading(True, math.radians(91.0), (50.0, 20.0), -1e-3)
    tread = reading(True, 0.0, (100.0, 30.0), -1e-6)
    assert felt_in(face + tread)[:6] == pytest.approx((150.0, 30.0, 100.0, 1e-6, True, True), abs=1e-12)
    assert felt_in(face)[:6] == (50.0, 0.0, 0.0, 0.0, False, True)


@given(st.floats(-0.5, 0.5), st.floats(1.0, 500.0), st.floats(-300.0, 300.0))
@settings(deadline=None, derandomize=True)
def test_friction_is_the_tangential_force_over_the_normal_force(slope: float, normal: float, rubbed: float) -> None:
    """Of a foot that presses along the normal of the slope, which leans forward downhill, and rubs along it."""
    into, along = np.array([-math.sin(slope), -math.cos(slope)]), np.array([math.cos(slope), -math.sin(slope)])
    forward, up = normal * into + rubbed * along
    foot = Felt(normal, forward, -up, 0.0, True, False)
    assert friction_ratio(foot, slope, 0.99 * normal) == pytest.approx(abs(rubbed) / normal, abs=1e-10)  # up to 300
    assert friction_ratio(foot, slope, 1.01 * normal) == 0.0


def test_what_bears_a_foot_is_summed_over_its_contacts() -> None:
    """Of contacts on level ground, by place ahead of the ankle, normal force, and friction; an empty slot is old."""
    data: list[float] = []
    for found, x, force, friction in ((1.0, -0.1, 30.0, 5.0), (1.0, 0.12, 70.0, -9.0), (0.0, 0.5, 11.0, 13.0)):
        data += [found, force, 0.0, friction, -1e-6, 0.3 + x, 0.0, 0.1, 0.0, 0.0, -1.0]
    borne = felt_in(data, q=(0.3, 0.1), sole=3)
    assert borne.moment == pytest.approx(0.1 * 30.0 - 0.12 * 70.0)
    assert borne.behind == pytest.approx(0.1)
    assert borne.ahead == pytest.approx(0.12)
    assert borne.shear == pytest.approx(-4.0)
