"""Files and tables of a command: drawings that fail leave the others, and tables fit where they are printed."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import Drawings, assert_refused, complaints, run, run_process
from PIL import Image

from mjbiped.errors import RenderError
from mjbiped.plotting import walk as plots
from mjbiped.plotting import width as plot_width
from mjbiped.records.record import Walk
from mjbiped.records.summary import MEASURES
from mjbiped.rendering import gl, video


def test_a_plot_is_as_wide_as_asked_for(record: Path, tmp_path: Path) -> None:
    plot = tmp_path / "narrow.png"
    assert run("render", record, "--no-video", "--plot", plot, "--plot-width", "single").exit_code == 0
    with Image.open(plot) as picture:
        assert picture.width == 1050  # 3.5 in of 300 dots
    assert plot_width.width() is plot_width.WIDTHS["page"]
    assert_refused(run("render", record, "--plot-width", "column"), "'page', 'double', 'single', 'slide'")
    assert run("render", record, "--no-video", "--plot", plot, "--panels", "torque,phase").exit_code == 0
    assert_refused(run("render", record, "--plot", plot, "--panels", "torqe"), "did you mean 'torque'")
    for command in ("sweep", "reproduce", "walk", "compare", "gait", "bifurcation", "basin", "stability"):
        assert "--plot-width [page|double|single|slide]" in run(command, "--help").stdout


def test_a_failed_plot_leaves_record_and_video(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, drawings: Drawings
) -> None:
    def plot_walk(*_: object, **__: object) -> None:
        raise RuntimeError("out of\nink")

    monkeypatch.setattr(plots, "plot_walk", plot_walk)
    out, plot, film = tmp_path / "walk.npz", tmp_path / "walk.png", tmp_path / "walk.mp4"
    words = ("walk", "level", "--steps", 1, "--out", out, "--plot", plot, "--video", film)
    result = run(*words, "--json")
    assert result.exit_code == 1
    assert result.stderr == f"Error: the plot {plot} was not written: RuntimeError: out of ink\n"
    assert json.loads(result.stdout)["files"] == {"record": str(out), "video": str(film)}
    assert Walk.load(out).outcome == "finished"
    assert [name for name, _ in drawings.calls] == ["render_video"]


def test_ctrl_c_in_a_drawing_leaves_the_record(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, drawings: Drawings
) -> None:
    def plot_walk(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(plots, "plot_walk", plot_walk)
    out, plot, film = tmp_path / "walk.npz", tmp_path / "walk.png", tmp_path / "walk.mp4"
    result = run("walk", "level", "--steps", 1, "--out", out, "--plot", plot, "--video", film)
    assert result.exit_code == 130
    assert f"wrote {out}" in result.stdout
    assert result.stderr == f"Error: the plot {plot} was not written: interrupted\n"
    assert not drawings.calls


def test_a_video_without_opengl_is_warned_of_and_comes_last(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, drawings: Drawings
) -> None:
    out, plot, film = tmp_path / "walk.npz", tmp_path / "walk.png", tmp_path / "walk.mp4"

    def render_video(*_: object, **__: object) -> None:
        assert Walk.load(out).outcome == "finished"
        assert plot.exists()
        raise RenderError("no OpenGL platform works here. On Debian or Ubuntu install libegl1 and libgl1-mesa-dri")

    monkeypatch.setattr(video, "render_video", render_video)
    monkeypatch.setattr(gl, "gl_available", lambda: None)
    result = run("walk", "level", "--steps", 1, "--out", out, "--plot", plot, "--video", film)
    assert result.exit_code == 2
    warning, error = result.stderr.splitlines()
    assert warning.startswith("Warning: there is no OpenGL platform")
    assert error.startswith(f"Error: the video {film} was not written")
    assert "libegl1" in error
    assert result.stdout.endswith(f"wrote {out}\nwrote {plot}\n")
    assert [name for name, _ in drawings.calls] == ["plot_walk"]


@pytest.mark.slow
def test_a_process_without_opengl_writes_the_record(tmp_path: Path) -> None:
    words = ("walk", "level", "--steps", 1, "--out", "walk.npz", "--video", "walk.mp4", "--json")
    result = run_process(*words, cwd=tmp_path, MUJOCO_GL="disable")
    assert result.returncode == 2
    assert "Error: the video walk.mp4 was not written: MUJOCO_GL=disable" in result.stderr
    assert "Traceback" not in result.stderr
    assert json.loads(result.stdout)["files"] == {"record": "walk.npz"}
    assert Walk.load(tmp_path / "walk.npz").outcome == "finished"
    assert not (tmp_path / "walk.mp4").exists()


@pytest.mark.slow
def test_table_fits_a_narrow_terminal_of_plain_ascii(tmp_path: Path) -> None:
    words = ("walk", "random", "--steps", 1)
    result = run_process(*words, cwd=tmp_path, COLUMNS="50", PYTHONIOENCODING="ascii")
    assert (result.returncode, complaints(result)) == (0, "")
    assert max(map(len, result.stdout.splitlines())) <= 50
    assert "cost of transport" in result.stdout


def test_no_line_of_a_piped_table_is_broken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)
    lines = run("walk", "random:seed=3", "--engine", "hybrid", "--steps", 1).output.splitlines()
    shown = {line.strip().split("  ")[0] for line in lines if line.strip()}
    assert {label for label, *_ in MEASURES if "estimate error" in label} <= shown
    assert "foot that holds it 99 % of the time, length" in shown
