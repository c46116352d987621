"""The drawings of docs/: they show what the model computes, in files that a page can carry."""

import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.axes import Axes
from PIL import Image

import mjbiped
from mjbiped.robots.compass import Array
from scripts.paper import diagrams, robot_drawing


def legs_of(axes: Axes) -> list[Array]:
    """Both legs as drawn, the stance leg first: from the foot to the hip, shape (2, 2)."""
    return [np.asarray(line.get_xydata()) for line in axes.lines if line.get_linewidth() > 5.0]


def lean(leg: Array) -> float:
    """Angle of a drawn leg from the vertical, clockwise, rad."""
    x, z = leg[1] - leg[0]
    return math.atan2(x, z)


def test_legs_stand_where_the_model_has_them() -> None:
    """To the right is the walking direction, and the ground falls there where its slope is positive."""
    robot = mjbiped.Compass()
    single, double = robot_drawing.draw_robot().axes
    stance, swing = legs_of(single)
    assert [lean(stance), lean(swing)] == pytest.approx(
        (robot_drawing.POSTURE + robot_drawing.SLOPE).tolist(), abs=1e-12
    )
    # the swing foot along the ground and along its normal, as the model has it
    along, normal = robot.swing_foot(robot_drawing.POSTURE)
    sine, cosine = math.sin(robot_drawing.SLOPE), math.cos(robot_drawing.SLOPE)
    place = [along * cosine + normal * sine, normal * cosine - along * sine]
    np.testing.assert_allclose(swing[0] - stance[0], place, rtol=0, atol=1e-12)
    np.testing.assert_allclose(stance[1], swing[1], rtol=0, atol=1e-12)
    # in double support both feet are on the ground, each on its slope
    rear, front = legs_of(double)
    first, second = robot_drawing.SLOPES
    break_z = -robot_drawing.BREAK * math.tan(first)
    assert rear[0].tolist() == [0.0, 0.0]
    assert front[0][0] > robot_drawing.BREAK
    assert front[0][1] == pytest.approx(break_z - (front[0][0] - robot_drawing.BREAK) * math.tan(second), abs=1e-9)
    assert [float(np.linalg.norm(leg[1] - leg[0])) for leg in (rear, front)] == pytest.approx([1.0, 1.0], abs=1e-12)


def test_the_estimator_is_drawn_as_it_works() -> None:
    """The leg that stood has not turned, and the angle between the normals is what (27) adds."""
    before, after, walk = diagrams.DRAWINGS["estimator"]().axes
    np.testing.assert_allclose(legs_of(before), legs_of(after), rtol=0, atol=1e-12)
    terrain, leaning, _ = robot_drawing.touchdown()
    first, second = robot_drawing.SLOPES
    assert lean(legs_of(before)[0]) == pytest.approx(leaning, abs=1e-12)
    x, _ = legs_of(before)[1][0]
    assert terrain.slope_at(x) - terrain.slope_at(0.0) == pytest.approx(second - first, abs=1e-12)
    lines = {str(line.get_label()): np.asarray(line.get_ydata()) for line in walk.lines}
    true, updated = lines["true slope"], lines["estimate with (27)"]
    assert np.unique(np.round(true, 6)).tolist() == [-2.0, 0.0, 1.0, 3.0]
    # exact but for the law (17), which moves the estimate by errors of tracking
    assert np.abs(true - updated).max() < 0.1
    assert lines["estimate without (27)"].max() > 3.05  # it overshoots


def test_clearance_names_what_is_measured() -> None:
    """`tests/gaits/test_passive.py` holds the numbers."""
    _, near = diagrams.draw_clearance().axes
    texts = " ".join(text.get_text().replace("\n", " ") for text in near.texts)
    for number in ("38.2 %", "8.7 cm behind", "45.2 %", "−0.86 mm"):
        assert number in texts


@pytest.mark.slow
def test_files_are_small(tmp_path: Path) -> None:
    done = CliRunner().invoke(diagrams.main, ["--folder", str(tmp_path / "images")])
    assert done.exit_code == 0
    for name in diagrams.DRAWINGS:
        path = tmp_path / "images" / f"{name}.png"
        assert str(path) in done.output
        with Image.open(path) as picture:
            assert picture.mode == "P"
        assert path.stat().st_size < 80_000
