"""`mjbiped export`: what it writes, and what it refuses."""

from __future__ import annotations

import sys
from pathlib import Path

import mujoco
import pytest
from command_line import run

import mjbiped
from mjbiped.control.controller import Unpowered
from mjbiped.exchange.ros import urdf_of


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The record of a passive walk."""
    path = tmp_path_factory.mktemp("record") / "walk.npz"
    mjbiped.walk(Unpowered(), mjbiped.Terrain.incline(2.0), steps=2).save(path)
    return path


def test_scene_of_a_terrain(tmp_path: Path) -> None:
    file = tmp_path / "scene.xml"
    done = run("export", "random", file, "--seed", 4, "--robot", "kneed", "--shank-mass", 0.4, "--initial", "rest")
    assert (done.exit_code, done.output) == (0, f"wrote {file}\n")
    model = mujoco.MjModel.from_xml_path(str(file))
    assert model.body("left_shank").mass[0] == 0.4
    assert "random (seed=4" in file.read_text(encoding="utf-8")


def test_scene_of_a_record(record: Path, tmp_path: Path) -> None:
    file = tmp_path / "scene.xml"
    assert run("export", record, file).exit_code == 0
    model = mujoco.MjModel.from_xml_path(str(file))
    assert model.key("start").qpos == pytest.approx(mjbiped.Walk.load(record).samples["qpos"][0], abs=1e-15)


def test_urdf_of_options_and_of_a_record(record: Path, tmp_path: Path) -> None:
    file = tmp_path / "robot.urdf"
    assert run("export", file, "--robot", "kneed", "--hip-mass", 3).exit_code == 0
    assert file.read_text(encoding="utf-8") == urdf_of(mjbiped.KneedBiped(hip_mass=3.0))
    assert run("export", record, file).exit_code == 0
    assert file.read_text(encoding="utf-8") == urdf_of(mjbiped.Compass())


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_tables_of_a_record_and_of_a_walk(suffix: str, record: Path, tmp_path: Path) -> None:
    file, beside = tmp_path / f"walk.{suffix}", tmp_path / f"walk_touchdowns.{suffix}"
    assert run("export", record, file).output == f"wrote {file}\nwrote {beside}\n"
    of_record = [each.read_bytes() for each in (file, beside)]
    words = ["walk", "incline:slope_deg=2", "--controller", "passive", "--steps", 2, "--out", file]
    assert run(*words).output.endswith(f"wrote {file}\nwrote {beside}\n")
    assert [each.read_bytes() for each in (file, beside)] == of_record


def test_recording_of_a_record(record: Path, tmp_path: Path) -> None:
    file = tmp_path / "walk.mcap"
    assert run("export", record, file).output == f"wrote {file}\n"
    assert file.read_bytes()[:8] == b"\x89MCAP0\r\n"


def test_a_missing_extra_is_told_before_the_walk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    done = run("walk", "level", "--out", tmp_path / "walk.parquet")
    assert done.exit_code == 2
    assert "needs PyArrow, which is not installed: pip install 'mjbiped[data]'" in " ".join(done.stderr.split())
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["a", "b", "scene.xml"], "2 sources are given, a and b; give one, then FILE"),
        (["level", "scene.docx"], "must end in .xml or .urdf or .csv or .parquet or .mcap"),
        (["level", "robot.urdf"], "robot.urdf is of a robot alone; leave 'level' out, or give a record"),
        (["level", "walk.csv"], "walk.csv is of a walk: give its record, as mjbiped export walk.npz walk.csv"),
        (["robot.urdf", "--seed", "3"], "--seed is for scenes (.xml); robot.urdf has no such thing"),
        (["nothing.npz", "scene.xml"], "nothing.npz: there is no such file"),
        (
            ["walk.npz", "scene.xml", "--robot", "kneed"],
            "--robot is for a TERRAIN; the record walk.npz has no",
        ),
        (["hills", "scene.xml"], "hills"),
        (["level", "scene.xml", "--thigh-mass", "3"], "--thigh-mass is for --robot kneed"),
    ],
)
def test_refuses(words: list[str], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    done = run("export", *words)
    assert done.exit_code == 2
    assert message in " ".join(done.stderr.split())
    assert not list(tmp_path.iterdir())
