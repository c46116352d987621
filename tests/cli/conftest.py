"""What tests of several commands share: files in a working folder, drawings that are none, and what may not be made."""

import sys
from functools import partial
from pathlib import Path
from typing import Any

import own_controllers
import pytest
from command_line import Drawings, run

FILES = {
    "trail.csv": "x,z\n-5,0.17461\n0,0\n40,-1.39685\n",  # 2 degrees downhill
    "spread.py": own_controllers.SPREAD,
    "bare.toml": "thigh_mass = 2.5\n",
    "steps.toml": "steps = 2\n",
    "broken.npz": "no record",
}


@pytest.fixture(scope="session")
def record(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The record of a short walk."""
    path = tmp_path_factory.mktemp("record") / "walk.npz"
    words = ("walk", "level", "--engine", "hybrid", "--steps", 2, "--initial-slope-estimate-deg", 3)
    assert run(*words, "--out", path, "--quiet").exit_code == 0
    return path


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, record: Path) -> Path:
    """The working folder, with terrains, controllers, robots and records."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    for name, text in FILES.items():
        own_controllers.write(tmp_path, name, text)
    (tmp_path / "walk.npz").write_bytes(record.read_bytes())
    return tmp_path


@pytest.fixture
def no_walk(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing may be simulated in MuJoCo."""

    def simulate(*_: object, **__: object) -> None:
        raise AssertionError("a walk was computed")

    monkeypatch.setattr("mjbiped.engines.mujoco.engine.stepped", simulate)


@pytest.fixture
def drawings(monkeypatch: pytest.MonkeyPatch) -> Drawings:
    """Of which module, what, and how each drawing would be made: its file is written, and nothing is drawn."""
    found: Drawings = []

    def draw(module: str, shown: object, path: Path, **settings: Any) -> None:
        found.append((module, shown, settings))
        path.write_text(module)

    for place in ("plotting.walk.plot_walk", "plotting.gait.plot_gait", "plotting.comparison.plot_comparison"):
        monkeypatch.setattr(f"mjbiped.{place}", partial(draw, place.split(".")[1]))
    monkeypatch.setattr("mjbiped.rendering.video.render_video", partial(draw, "video"))
    monkeypatch.setattr("mjbiped.rendering.gl.gl_available", lambda: "egl")
    return found
