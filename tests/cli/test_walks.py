"""`mjbiped walk`, `compare` and `render`: what they print and write, and what they refuse before a walk."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from command_line import Drawings, assert_refused, complaints, run, run_process

import mjbiped
from mjbiped.records import measures
from mjbiped.records.record import Walk
from mjbiped.terrain.presets import PRESETS


@pytest.mark.slow
def test_walk_in_a_process_prints_json_alone_and_writes_what_it_lists(tmp_path: Path) -> None:
    # quiet: a first walk says on stderr that something is being compiled
    words = ("walk", "stairs:rise=-0.02", "--steps", 2, "--quiet", "--json", "--out", "a.npz", "--plot", "a.svg")
    result = run_process(*words, cwd=tmp_path)
    assert (result.returncode, result.stderr) == (0, "")
    printed = json.loads(result.stdout)
    assert printed.pop("files") == {"record": "a.npz", "plot": "a.svg"}
    walk = Walk.load(tmp_path / "a.npz")
    assert printed.pop("settings") == walk.settings
    assert printed == json.loads(json.dumps(measures.summary(walk)))
    assert (printed["outcome"], printed["steps"]) == ("finished", 2)
    assert walk.terrain == mjbiped.Terrain.stairs(rise=-0.02)
    assert "<svg" in (tmp_path / "a.svg").read_text(encoding="utf-8")


def test_walk_prints_a_table_of_all_measures_and_the_files(tmp_path: Path, drawings: Drawings) -> None:
    out, plot, film = tmp_path / "[b].npz", tmp_path / "a.png", tmp_path / "a.mp4"
    words = ("walk", "--steps", 1, "--out", out, "--plot", plot, "--video", film)
    result = run(
        *words,
        "--slow-motion",
        2,
        "--fps",
        25,
        "--camera",
        "side",
        "--video-size",
        "320x200",
        "--hide",
        "shadows,ghost",
    )
    assert (result.exit_code, complaints(result)) == (0, "")
    summary = measures.summary(Walk.load(out))
    for shown in (
        "finished",
        "mixed",
        f"{summary['distance_m']:.3f}",
        f"{summary['cost_of_transport']:.4f}",
        f"{summary['peak_ankle_torque_Nm']:.2f}",
        f"{summary['largest_slip_m'] * 1e3:.4f}",
        "N m",
        "mm",
        "deg",
    ):
        assert shown in result.stdout
    assert result.stdout.endswith(f"wrote {out}\nwrote {plot}\nwrote {film}\n")
    size = {"width": 320, "height": 200, "fps": 25, "camera": "side", "slow_motion": 2.0, "start": None, "stop": None}
    assert drawings.calls == [
        ("plot_walk", {"steps": 1}),
        ("render_video", {"steps": 1, **size, "hide": ("shadows,ghost",), "flags": (), "progress": True}),
    ]


def test_quiet_walk_says_nothing(record: Path, tmp_path: Path) -> None:
    out = tmp_path / "walk.npz"
    out.write_text("an older file is replaced")
    assert run("walk", "level", "--steps", 1, "--out", out, "--quiet").output == ""
    assert Walk.load(out) == Walk.load(record)


def test_a_fall_is_a_result(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo may write its log
    words = ("walk", "level", "--controller", "passive", "--initial", "0.1,0.1,1,1", "--json", "--timestep", 5e-4)
    result = run(*words)
    assert result.exit_code == 0
    printed = json.loads(result.stdout)
    assert (printed["outcome"], printed["steps"], printed["cost_of_transport"]) == ("fell", 0, None)
    assert "fell" in run(*words[:-3], "--timestep", 5e-4).stdout


def test_refusal_in_a_process(tmp_path: Path) -> None:
    result = run_process("walk", "incline:slope_deg=50", cwd=tmp_path)
    assert (result.returncode, result.stdout) == (2, "")
    assert result.stderr.startswith("Error: terrain incline: slope_deg")
    assert result.stderr.count("\n") == 1


def test_compare_prints_both_engines_and_writes_both_records(tmp_path: Path, drawings: Drawings) -> None:
    out, plot = tmp_path / "both.npz", tmp_path / "both.png"
    result = run("compare", "level", "--steps", 2, "--out", out, "--plot", plot)
    assert (result.exit_code, complaints(result)) == (0, "")
    records = [Walk.load(tmp_path / f"both_{engine}.npz") for engine in ("mujoco", "hybrid")]
    assert [record.settings["engine"] for record in records] == ["mujoco", "hybrid"]
    for record in records:
        assert f"{record.cost_of_transport:.4f}" in result.stdout
    difference = records[0].cost_of_transport - records[1].cost_of_transport
    assert f"{difference:+.3g}" in result.stdout
    assert f"{100 * difference / records[1].cost_of_transport:+.2f}" in result.stdout
    assert "The engines agree at all 2 touchdowns" in result.stdout
    names = [tmp_path / "both_mujoco.npz", tmp_path / "both_hybrid.npz", plot]
    assert result.stdout.endswith("".join(f"wrote {name}\n" for name in names))
    assert drawings.calls == [("plot_comparison", {"steps": 2})]


@pytest.mark.slow
def test_compare_as_json_in_a_process(tmp_path: Path) -> None:
    words = ("compare", "stairs:rise=0.045,first=1.0,count=1", "--steps", 3, "--json")
    result = run_process(*words, cwd=tmp_path)
    assert (result.returncode, complaints(result)) == (0, "")
    printed = json.loads(result.stdout)
    assert printed["parting"]["touchdown"] == 3
    assert "riser" in printed["parting"]["causes"][0]
    assert printed["measures"]["steps"] == {"mujoco": 3, "hybrid": 3, "difference": 0, "difference_percent": 0.0}
    assert len(printed["touchdowns"]["x"]) == 3
    assert printed["settings"]["hybrid"]["engine"] == "hybrid"
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("terrain", [*PRESETS[:-1], "recorded:file=hill.csv,seed=2", "hill.csv", "hill.toml"])
def test_compare_walks_every_terrain(terrain: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("hill.csv").write_text("x,z\n0,0\n0.6,0.01\n5,-0.1\n", encoding="utf-8")
    Path("hill.toml").write_text("segments = [[0.5, 0.0], [2.0, 2.0, -0.01]]\n", encoding="utf-8")
    result = run("compare", terrain, "--steps", 2)
    assert (result.exit_code, complaints(result)) == (0, "")
    assert "cost of transport" in result.stdout
    assert "The engines agree at all 2 touchdowns" in " ".join(result.stdout.split())


def test_compare_shows_falls_of_both(tmp_path: Path) -> None:
    result = run("compare", "level", "--controller", "passive", "--initial=-0.19,0.19,0.3,0")
    assert (result.exit_code, complaints(result)) == (0, "")
    assert re.search(r"outcome +fell +fell", result.stdout)


@pytest.mark.usefixtures("no_walk")
@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("levle",), "level"),
        (("level", "--timestep", 0), "timestep"),
        (("level", "--steps", 0), "--steps"),
        (("level", "--out", "walk.txt"), "must end in .npz"),
        (("level", "--engine", "hybrid"), "No such option"),
        (
            ("level", "--controller", "passive", "--position-gain", 3),
            "controller passive 'position_gain'",
        ),
        (("no.csv",), "no.csv"),
    ],
)
def test_compare_refuses_before_it_walks(
    words: tuple[object, ...], reason: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert_refused(run("compare", *words), reason)
    assert not list(tmp_path.iterdir())


def test_render_draws_beside_the_record(record: Path, drawings: Drawings) -> None:
    words = ("--hide", "caption", "--flag", "contactpoint", "--flag", "no-skin", "--start", 0.1, "--stop", 0.3)
    result = run("render", record, *words)
    film = record.with_suffix(".mp4")
    assert (result.exit_code, result.stdout, result.stderr) == (0, f"wrote {film}\n", "")
    ((name, settings),) = drawings.calls
    assert name == "render_video"
    assert (settings["width"], settings["height"], settings["fps"], settings["camera"]) == (1280, 720, 30, "track")
    assert (settings["slow_motion"], settings["start"], settings["stop"]) == (1.0, 0.1, 0.3)
    assert (settings["hide"], settings["flags"]) == (("caption",), ("contactpoint", "no-skin"))


def test_render_draws_where_it_is_told(record: Path, drawings: Drawings, tmp_path: Path) -> None:
    film, plot = tmp_path / "other.mp4", tmp_path / "other.png"
    assert run("render", record, film, "--plot", plot, "--quiet").output == ""
    assert [name for name, _ in drawings.calls] == ["plot_walk", "render_video"]
    assert film.exists()
    assert run("render", record, "--no-video", "--plot", plot).stdout == f"wrote {plot}\n"
    assert [name for name, _ in drawings.calls[2:]] == ["plot_walk"]


def _truncated(whole: bytes) -> bytes:
    return whole[: len(whole) // 2]


def _foreign(_: bytes) -> bytes:
    return b"no record"


@pytest.mark.parametrize("change", [_truncated, _foreign])
def test_render_refuses_files_that_are_no_records(
    change: Callable[[bytes], bytes], record: Path, tmp_path: Path, drawings: Drawings
) -> None:
    path = tmp_path / "walk.npz"
    path.write_bytes(change(record.read_bytes()))
    assert_refused(run("render", path), "no walk's record")
    assert not drawings.calls


def test_render_refuses(record: Path, tmp_path: Path, drawings: Drawings) -> None:
    assert_refused(run("render", tmp_path / "walk.npz"), "there is no such file")
    assert_refused(run("render", record, tmp_path / "walk.avi"), "must end in .mp4 or .gif")
    assert_refused(run("render", record, tmp_path / "nowhere" / "walk.mp4"), "there is no folder")
    assert_refused(run("render", record, "--no-video"), "--no-video")
    assert_refused(run("render", record, "--video-size", "1x1"), "even pixels")
    assert not drawings.calls
