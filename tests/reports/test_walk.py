"""The report of a walk: what stands in the page, and that it needs nothing else."""

import base64
import dataclasses
import math
import re
from pathlib import Path

import numpy as np
import pytest
from report_pages import packed
from walk_cases import Rude

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.control.registry import make_controller
from mjbiped.rendering.gl import gl_available
from mjbiped.reports import walk as figures
from mjbiped.reports.walk import report_walk


def report(walk: mjbiped.Walk, path: Path) -> str:
    report_walk(walk, path, video=False)
    return path.read_text()


def test_the_page_holds_everything_and_is_the_same_each_time(walk: mjbiped.Walk, tmp_path: Path) -> None:
    page = report(walk, tmp_path / "walk.html")
    assert page == report(walk, tmp_path / "again.html")
    assert not re.findall(r"""(?:src|href)=["'](?!data:)""", page)  # nothing is fetched
    assert "default-src 'none'" in page  # and the browser would refuse to
    content = packed(page)
    assert [*content["plots"]] == ["ground", "time", "phases"]
    assert len(content["plots"]["time"]["data"]) == 11
    assert content["data"]["time"] == np.round(walk.samples["time"], 5).tolist()
    for text in ("robot.leg_mass", *(text for label, value, _ in walk.summary().rows for text in (label, value))):
        assert text in page
    for time, slope in zip(walk.touchdowns["time"], walk.touchdowns["slope"], strict=True):
        cells = re.search(rf"<td>{time:.4f}</td>" + r"\s*<td>([^<]*)</td>" * 3, page)
        assert cells
        assert cells[3] == f"{math.degrees(slope):.4f}".replace("-", "−")
    low = {name: rows - 1e-9 if name == "z" else rows for name, rows in walk.touchdowns.items()}
    assert "−0.0000" not in report(dataclasses.replace(walk, touchdowns=low), tmp_path / "low.html")
    assert len(page) < 2_400_000  # bytes, most of them Plotly's: docs/reports.md says so


def test_texts_of_a_record_are_escaped(walk: mjbiped.Walk, tmp_path: Path) -> None:
    evil = "</script><script>alert(1)</script>"
    settings = {**walk.settings, "warnings": {evil: 2}, "terrain": {**walk.settings["terrain"], "name": evil}}
    page = report(dataclasses.replace(walk, settings=settings), tmp_path / "walk.html")
    assert "<script>alert" not in page
    assert "&lt;/script&gt;" in page
    assert "(2 times)" in page


def test_long_walks_keep_their_steps_ends(walk: mjbiped.Walk, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(figures, "MOST_SAMPLES", 300)
    keep = figures.shown_samples(walk)
    assert 200 < len(keep) <= 300 + 2 * walk.steps + 1  # some, and both ends of each step
    ends = np.flatnonzero(np.diff(walk.to_pandas().samples.step.to_numpy()))
    assert {*ends, *(ends + 1), 0, len(walk.samples["time"]) - 1} <= {*keep.tolist()}
    assert any("every 4th is drawn" in figure.note for figure in figures.walk_figures(walk))


def test_there_is_always_a_page(walk: mjbiped.Walk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without samples, steps or OpenGL as well."""
    ground = mjbiped.Terrain.level()
    bare = mjbiped.walk(PassiveController(), ground, engine="hybrid", steps=1, initial="rest", sample_period=None)
    assert "holds no samples" in report(bare, tmp_path / "bare.html")
    fallen = mjbiped.walk(PassiveController(), ground, engine="hybrid", steps=9, initial=(0.1, 0.1, -0.5, 0.0))
    page = report(fallen, tmp_path / "fallen.html")
    assert fallen.outcome in page
    # no estimate, and zeros alone of slope, torques, pressure and power: angles and rates are left
    assert len(packed(page)["plots"]["time"]["data"]) == 4
    assert {name: values for name, values, _ in packed(page)["data"]["told"]}["estimate"][0] is None

    def failing(*_: object, **__: object) -> None:
        raise mjbiped.RenderError("no OpenGL platform works")

    monkeypatch.setattr("mjbiped.rendering.video.render_video", failing)
    report_walk(walk, tmp_path / "walk.html")
    page = (tmp_path / "walk.html").read_text()
    assert "There is no video: no OpenGL platform works." in page
    assert "<video" not in page


def test_numbers_that_are_none_stay_out_of_the_pages_data(tmp_path: Path) -> None:
    slope = mjbiped.Terrain.incline(2.0)
    diverged = mjbiped.walk(Rude(4, 0.0, 0.3), slope, engine="mujoco", steps=3)  # NaN torque from 0.3 s on
    assert np.isnan(diverged.samples["torque"]).any()
    data = packed(report(diverged, tmp_path / "walk.html"))["data"]  # which refuses NaN
    assert None in next(values for name, values, _ in data["told"] if name == "ankle")


@pytest.mark.slow
@pytest.mark.skipif(gl_available() is None, reason="no OpenGL platform")
def test_the_video_stands_in_the_page(controller: AdaptiveController, tmp_path: Path) -> None:
    short = mjbiped.walk(controller, mjbiped.Terrain.level(), engine="hybrid", steps=1)
    report_walk(short, tmp_path / "walk.html")
    found = re.search(r'src="data:video/mp4;base64,([^"]+)"', (tmp_path / "walk.html").read_text())
    assert found
    assert base64.b64decode(found[1])[4:8] == b"ftyp"


def test_knees_are_shown(kneed: mjbiped.Walk, tmp_path: Path) -> None:
    page = report(kneed, tmp_path / "walk.html")
    content = packed(page)
    lines = {line["name"] for plot in ("time", "phases") for line in content["plots"][plot]["data"]}
    assert lines >= {"stance knee", "swing knee", "knee strike", "swing thigh", "swing shank"}
    half = len(kneed.samples["time"]) // 3
    limbs, stance = kneed.robot.limbs(kneed.samples["qpos"][half]), kneed.samples["stance"][half]
    for leg, side in (("stance", stance), ("swing", 1 - stance)):
        shown = np.array(content["data"]["legs"][f"{leg} leg now"])[:, :, half]
        assert shown == pytest.approx(limbs[side], abs=1e-4)
    assert "greatest flexion (°)" in page


def test_a_walk_in_space(tmp_path: Path) -> None:
    robot, ground = mjbiped.Compass3D(), mjbiped.Terrain.level(lateral_deg=1.0)
    walk = mjbiped.walk(make_controller("adaptive", robot, {}), ground, robot=robot, engine="hybrid", steps=2)
    page = report(walk, tmp_path / "walk.html")
    above = packed(page)["plots"]["above"]
    assert [trace["name"] for trace in above["data"]] == ["swing foot", "middle of the hip", "stance foot"]
    for told in ("slope to the left", "peak torque, ankle roll", "ankle roll's part"):
        assert told in page.replace("&#39;", "'"), told
