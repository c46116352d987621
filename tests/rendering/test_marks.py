"""Marks, words and the chart: where they should be, and as large as what they stand for."""

import math
from collections.abc import Sequence
from functools import cache
from itertools import pairwise

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

import mjbiped
from controllers import AdaptiveController
from mjbiped import Terrain, Walk
from mjbiped.control.registry import make_controller
from mjbiped.records.signals import SIGNALS, torques_of
from mjbiped.rendering.marks import FORCE_COLOUR, GHOST_COLOUR, MOST_GEOMS, Scales, arc_sweep, draw_marks
from mjbiped.rendering.overlay import Chart, Overlay, Pixels
from mjbiped.rendering.scene import Moment, Moments, Pair, beside_posture
from mjbiped.utils.palette import rgb

ROBOT = mjbiped.Compass()
ANKLE_COLOUR, HIP_COLOUR = (rgb(signal.colour) for signal in torques_of(mjbiped.Compass))
ESTIMATE_COLOUR = rgb(SIGNALS["slope_estimate"].colour)
SCALES = Scales(torque=10.0, force=ROBOT.weight)
MODEL = mujoco.MjModel.from_xml_string("<mujoco/>")
EVERYTHING = ("torque", "force", "ghost", "estimate", "traces", "shadows")

Places = NDArray[np.float64]


def foot_of(robot: mjbiped.Compass, hip: Sequence[float], angle: float) -> Pair:
    """Place of the foot of a leg that leans by an angle from the vertical."""
    return hip[0] - robot.leg_length * math.sin(angle), hip[1] - robot.leg_length * math.cos(angle)


@cache
def walking() -> Moment:
    """On its left leg, down 2 degrees."""
    law = make_controller("adaptive", ROBOT, {})
    return Moments(mjbiped.walk(law, Terrain.incline(2.0), engine="hybrid", steps=1)).at(0.3)


def moment(**values: object) -> Moment:
    return walking()._replace(**values)  # type: ignore[arg-type]


def marks(at: Moment, *elements: str) -> list[mujoco.MjvGeom]:
    scene = mujoco.MjvScene(MODEL, maxgeom=MOST_GEOMS)
    draw_marks(scene, at, ROBOT, SCALES, elements or EVERYTHING)
    return [scene.geoms[index] for index in range(scene.ngeom)]


def ends(geom: mujoco.MjvGeom) -> tuple[Places, Places]:
    """Start and stop of a bar or a capsule, x and z in m."""
    axis = geom.mat[:, 2] * geom.size[2]
    return (geom.pos - axis)[[0, 2]], (geom.pos + axis)[[0, 2]]


def of_colour(geoms: list[mujoco.MjvGeom], colour: tuple[float, float, float]) -> list[mujoco.MjvGeom]:
    """Those of this colour."""
    return [geom for geom in geoms if np.allclose(geom.rgba[:3], colour, atol=1e-5)]


def test_soles_lie_along_the_ground_under_either_foot() -> None:
    scene, at = mujoco.MjvScene(MODEL, maxgeom=MOST_GEOMS), moment()
    draw_marks(scene, at, mjbiped.Compass(sole=(0.05, 0.15)), SCALES, ())
    assert scene.ngeom == 2
    assert not marks(at, "none")  # without a sole
    along = np.array((math.cos(at.slope), -math.sin(at.slope)))
    for side, angle in enumerate(at.qpos[2:]):
        heel, toe = ends(scene.geoms[side])
        foot = np.array(foot_of(ROBOT, at.qpos[:2], angle))
        np.testing.assert_allclose(heel, foot - 0.05 * along, atol=1e-6)  # geoms are of single precision
        np.testing.assert_allclose(toe, foot + 0.15 * along, atol=1e-6)


@pytest.mark.parametrize(("torque", "place"), [(-1.0, 1.0 / 95.0), (-90.0, 0.15), (90.0, -0.05)])
def test_on_a_sole_the_force_stands_on_the_centre_of_pressure(torque: float, place: float) -> None:
    """It is the torque over the normal force, within the sole."""
    robot, scene = mjbiped.Compass(sole=(0.05, 0.15)), mujoco.MjvScene(MODEL, maxgeom=MOST_GEOMS)
    at = moment(torque=(torque, 0.0), slope=0.0, force=(0.0, 95.0))
    draw_marks(scene, at, robot, SCALES, {"force"})
    shaft = of_colour([scene.geoms[k] for k in range(scene.ngeom)], rgb(FORCE_COLOUR))[2]
    _, tip = ends(shaft)
    assert tip[0] - foot_of(ROBOT, at.qpos[:2], at.qpos[2])[0] == pytest.approx(place, abs=1e-6)


def arc(torque: Pair, colour: tuple[float, float, float]) -> tuple[float, float]:
    """Angle that an arc goes round, clockwise, and its width."""
    at = moment(torque=torque)
    pieces = of_colour(marks(at, "torque"), colour)[:-2]  # the last two are the arrow's head
    hip = at.qpos[:2]
    centre = np.array(hip if colour is HIP_COLOUR else foot_of(ROBOT, hip, at.qpos[2]))
    total = 0.0
    for one, next_ in pairwise(pieces):
        (x0, z0), (x1, z1) = (geom.pos[[0, 2]] - centre for geom in (one, next_))
        total += math.atan2(z0 * x1 - x0 * z1, x0 * x1 + z0 * z1)
    total *= len(pieces) / (len(pieces) - 1)  # from the first piece's beginning to the last one's end
    return total, float(pieces[0].size[0])


@pytest.mark.parametrize(("colour", "joint"), [(ANKLE_COLOUR, 0), (HIP_COLOUR, 1)])
def test_arcs_turn_as_the_torque_and_grow_with_it(colour: tuple[float, float, float], joint: int) -> None:
    sizes = []
    for torque in (-10.0, -5.0, -0.5, -0.1, 0.1, 0.5, 5.0, 10.0):
        pair = (torque, 0.0) if joint == 0 else (0.0, torque)
        turned, width = arc(pair, colour)
        assert math.copysign(1.0, turned) == math.copysign(1.0, torque)  # clockwise is positive, as legs lean forward
        sizes.append((turned, width))
    assert all(one[0] < next_[0] for one, next_ in pairwise(sizes))
    assert sizes[-1][1] > sizes[-3][1]
    assert sizes[-1][0] == pytest.approx(math.radians(300.0))
    assert arc_sweep(0.25) == pytest.approx(math.radians(150.0))  # the area is the torque


@pytest.mark.parametrize("force", [(0.0, 98.1), (30.0, 80.0), (-30.0, 120.0)])
def test_the_force_points_along_the_force_into_the_foot(force: Pair) -> None:
    at = moment(force=force)
    shaft, *barbs = of_colour(marks(at, "force"), rgb(FORCE_COLOUR))
    tail, tip = ends(shaft)
    assert tip == pytest.approx(foot_of(ROBOT, at.qpos[:2], at.qpos[2]), abs=1e-6)
    assert tip - tail == pytest.approx(0.27 * np.array(force) / ROBOT.weight, abs=1e-6)
    for barb in barbs:
        stop, start = ends(barb)
        assert start == pytest.approx(tip, abs=1e-6)
        assert np.dot(stop - start, force) < 0.0


def test_the_estimate_is_a_line_through_the_foot() -> None:
    at = moment(slope_estimate=math.radians(-4.0))
    [line] = of_colour(marks(at, "estimate"), ESTIMATE_COLOUR)
    start, stop = ends(line)
    assert 0.5 * (start + stop) == pytest.approx(foot_of(ROBOT, at.qpos[:2], at.qpos[2]), abs=1e-6)
    assert math.degrees(math.atan2(*(stop - start)[::-1])) == pytest.approx(4.0, abs=1e-4)  # up, for down is positive


def test_the_ghost_stands_on_the_foot_in_the_reference() -> None:
    foot = np.array(foot_of(ROBOT, moment().qpos[:2], moment().qpos[2]))
    slope, qpos = moment().slope, np.array(moment().qpos)
    *_, reference = beside_posture(ROBOT, mjbiped.Terrain.level(), qpos, 0, slope, (0.1, -0.3))
    at = moment(reference=reference)
    stance, swing = of_colour(marks(at, "ghost"), rgb(GHOST_COLOUR))
    hip = foot + np.array((math.sin(0.1 + at.slope), math.cos(0.1 + at.slope)))
    for leg, angle in ((stance, 0.1), (swing, -0.3)):
        there = sorted(map(tuple, ends(leg)), key=lambda place: -place[1])
        assert there[0] == pytest.approx(hip, abs=1e-6)
        assert there[1] == pytest.approx(foot_of(ROBOT, tuple(hip), angle + at.slope), abs=1e-6)
        assert 0.0 < leg.rgba[3] < 1.0


def blank(width: int = 640, height: int = 360) -> Pixels:
    return np.full((height, width, 3), 200, dtype=np.uint8)


@pytest.mark.parametrize("pixels_per_metre", [3.0, 50.0, 317.0, 4000.0])
def test_the_scale_is_as_long_as_it_says(pixels_per_metre: float) -> None:
    frame = blank()
    over = Overlay(frame, 360)
    text = over.scale(pixels_per_metre, 50)
    length, unit = text.split()
    assert unit == "m"
    wide = round(float(length) * pixels_per_metre)
    assert 640 / 7 / 2.6 < wide <= 640 / 7 * 1.02 + 1  # 1, 2 or 5 times a power of ten
    columns = np.flatnonzero((frame[:, :, 0] < 100).any(axis=0))
    assert np.ptp(columns) + 1 >= wide - 1


CURSOR = (200, 30, 30)
SIZE = (640, 100)


@pytest.fixture(scope="module")
def walk(controller: AdaptiveController) -> Walk:
    return mjbiped.walk(controller, Terrain.incline(1.0), engine="hybrid", steps=40)


def drawn(chart: Chart, time: float) -> Pixels:
    frame = np.zeros((SIZE[1], SIZE[0], 3), dtype=np.uint8)
    chart.draw(frame, time)
    return frame


def cursor(frame: Pixels) -> float:
    """Column of the cursor's middle."""
    return float(np.flatnonzero((frame == CURSOR).all(axis=2).any(axis=0)).mean())


def test_the_cursor_goes_with_time_and_the_rest_stands(walk: Walk) -> None:
    chart = Chart(walk, 2.0, 12.0, *SIZE)
    frames = [drawn(chart, time) for time in (2.0, 4.5, 7.0, 12.0)]
    columns = np.array([cursor(frame) for frame in frames])
    # even distances but for whole pixels
    assert columns - columns[0] == pytest.approx(np.array([0.0, 0.25, 0.5, 1.0]) * np.ptp(columns), abs=1.0)
    assert (frames[0] != frames[2]).any(axis=2).any(axis=0).sum() <= 2  # a column each
