"""What a walk says of itself: printed, by name, and in a notebook."""

import base64
import re
from pathlib import Path

import pytest
from command_line import run
from PIL import Image

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.plotting.walk import plot_walk
from mjbiped.records import measures
from mjbiped.records.summary import in_words
from mjbiped.rendering.gl import gl_available


@pytest.fixture(scope="module")
def walk(controller: AdaptiveController) -> mjbiped.Walk:
    return mjbiped.walk(controller, mjbiped.Terrain.mixed(), engine="hybrid", steps=4)


def test_printed_it_is_what_the_command_line_prints(walk: mjbiped.Walk, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "100")  # a narrow terminal folds lines
    shown = str(walk.summary()).splitlines()
    printed = run("walk", "mixed", "--engine", "hybrid", "--steps", 4).stdout
    words = [" ".join(line.split()) for line in printed.splitlines()]
    assert shown
    assert all(" ".join(line.split()) in words for line in shown)


def test_a_fall_at_once_for_a_wrong_slope_estimate_names_the_option() -> None:
    words = ("walk", "incline:slope_deg=2", "--controller", "passivity", "--engine", "hybrid", "--steps", 5)
    fallen = " ".join(run(*words).stdout.split())
    assert "outcome fell" in fallen
    assert "it starts on 2.0° with a slope estimate of 0.0°; give --initial-slope-estimate-deg 2, " in fallen
    walked = run(*words, "--initial-slope-estimate-deg", 2).stdout
    assert "finished" in walked
    assert "cause" not in walked
    passive = run("walk", "level", "--controller", "passive", "--engine", "hybrid", "--initial", "0,-0.1,0.5,0").stdout
    assert "outcome" in passive
    assert "finished" not in passive
    assert "cause" not in passive  # it has no estimate


def test_by_name_it_has_all_measures(walk: mjbiped.Walk) -> None:
    assert dict(walk.summary()) == measures.summary(walk)
    assert len(walk.summary()) == len(measures.summary(walk))
    assert repr(walk.summary()) == str(walk.summary())


def test_a_notebook_shows_measures_and_the_time_lapse(walk: mjbiped.Walk, tmp_path: Path) -> None:
    page = walk._repr_html_()
    assert "finished" in page
    assert "cost of transport, absolute" in page
    picture = re.search(r"base64,([^\"]+)", page)
    assert picture
    (tmp_path / "shown.png").write_bytes(base64.b64decode(picture[1]))
    with Image.open(tmp_path / "shown.png") as image:
        assert image.size[0] == 768  # 9.6 inches at 80 dots
    assert len(page) < 100_000  # bytes: a notebook keeps each
    assert "<tr>" in walk.summary()._repr_html_()


def test_texts_of_a_record_are_not_taken_for_html(controller: AdaptiveController) -> None:
    terrain = mjbiped.Terrain.from_segments([(2.0, 0.0, 0.0)], name="<script>alert(1)</script>")
    bare = mjbiped.walk(controller, terrain, engine="hybrid", steps=1, sample_period=None)
    assert "<script>" not in bare._repr_html_()
    assert "<img" not in bare._repr_html_()  # without samples there is no picture, and no error


@pytest.mark.slow
def test_the_figure_is_the_one_of_the_command_line(walk: mjbiped.Walk, tmp_path: Path) -> None:
    walk.plot(tmp_path / "method.png")
    plot_walk(walk, tmp_path / "function.png")
    assert (tmp_path / "method.png").read_bytes() == (tmp_path / "function.png").read_bytes()
    assert len(walk.plot().axes) > 3


@pytest.mark.skipif(gl_available() is None, reason="no OpenGL platform")
def test_the_video_takes_the_settings_of_the_renderer(walk: mjbiped.Walk, tmp_path: Path) -> None:
    walk.video(tmp_path / "walk.mp4", width=64, height=64, fps=2)
    assert (tmp_path / "walk.mp4").read_bytes()[4:8] == b"ftyp"
    with pytest.raises(mjbiped.InputError):
        walk.video(tmp_path / "walk.gif2")


def test_what_does_not_exist_has_no_unit() -> None:
    walked = mjbiped.walk(PassiveController(), mjbiped.Terrain.incline(2.0), engine="hybrid", steps=2)
    rows = {label: (value, unit) for label, value, unit in walked.summary().rows}
    assert rows["final estimate error"] == ("-", "")
    assert rows["speed"][1] == "m/s"


@pytest.mark.parametrize(
    ("value", "form", "said"),
    [(-1e-9, ".2f", "0.00"), (-0.004, ".2f", "-0.40"), (-0.0, "+.3g", "0"), (3, "d", "300"), (None, ".2f", "-")],
)
def test_a_small_negative_number_is_no_negative_zero(value: float | None, form: str, said: str) -> None:
    assert in_words(value, 100, form) == said
