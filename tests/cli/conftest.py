"""What tests of several commands share: a record, drawings that are none, and walks that must not be made."""

from pathlib import Path

import pytest
from command_line import Drawings, run

from mjbiped.engines.mujoco import engine as mujoco_run
from mjbiped.plotting import comparison, gait, walk
from mjbiped.rendering import gl, video


@pytest.fixture(scope="session")
def record(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The record of a short walk."""
    path = tmp_path_factory.mktemp("record") / "walk.npz"
    assert run("walk", "level", "--steps", 1, "--out", path, "--quiet").exit_code == 0
    return path


@pytest.fixture
def no_walk(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing may be simulated."""

    def simulate(*_: object, **__: object) -> None:
        raise AssertionError("a walk was computed")

    monkeypatch.setattr(mujoco_run, "stepped", simulate)


@pytest.fixture
def drawings(monkeypatch: pytest.MonkeyPatch) -> Drawings:
    """Nothing is drawn in earnest."""
    fake = Drawings()
    monkeypatch.setattr(walk, "plot_walk", fake.plot_walk)
    monkeypatch.setattr(gait, "plot_gait", fake.plot_gait)
    monkeypatch.setattr(comparison, "plot_comparison", fake.plot_comparison)
    monkeypatch.setattr(video, "render_video", fake.render_video)
    monkeypatch.setattr(gl, "gl_available", lambda: "egl")
    return fake
