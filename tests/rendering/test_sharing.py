"""Frames that several processes draw are those that one draws, whatever becomes of the others."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.records.record import Walk
from mjbiped.rendering import sharing
from mjbiped.rendering.gl import ensure_gl, gl_available
from mjbiped.rendering.look import look
from mjbiped.rendering.overlay import Pixels
from mjbiped.rendering.sharing import drawn, processes_for
from mjbiped.rendering.stage import Film
from mjbiped.robots.compass import Compass
from mjbiped.terrain.terrain import Terrain

needs_gl = pytest.mark.skipif(gl_available() is None, reason="no OpenGL platform")


@pytest.fixture
def delivered(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """Whether each frame that another process was asked for came from it."""
    found: list[bool] = []
    received = sharing._received

    def noted(process: subprocess.Popen[bytes], size: int) -> bytes:
        sent = received(process, size)
        found.append(bool(sent))
        return sent

    monkeypatch.setattr(sharing, "_received", noted)
    return found


@pytest.fixture(scope="module")
def walk() -> Walk:
    gait = mjbiped.find_passive_gait(Compass(), slope=np.deg2rad(2))
    return mjbiped.walk(AdaptiveController(Compass(), gait), Terrain.stairs(tread=1.0, rise=0.01), steps=4)


def film(walk: Walk, frames: int) -> Film:
    return Film(160, 240, "track", look("chart"), 0.0, walk.end[0], 1.0, round(frames / walk.end[0]), frames)


@pytest.fixture(scope="module")
def alone(walk: Walk) -> list[Pixels]:
    """The frames of one process."""
    with drawn(walk, film(walk, 8), 1) as (_, frames):
        return list(frames)


def assert_same(frames: list[Pixels], alone: list[Pixels]) -> None:
    assert len(frames) == len(alone) == 8
    for one, other in zip(frames, alone, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.slow
@needs_gl
@pytest.mark.parametrize("processes", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_frames_are_those_of_one_process(
    walk: Walk, alone: list[Pixels], delivered: list[bool], processes: int
) -> None:
    with drawn(walk, film(walk, 8), processes) as (_, frames):
        assert_same(list(frames), alone)
    assert delivered == [True] * sum(number % processes > 0 for number in range(8))
    assert not np.array_equal(alone[0], alone[4])


@needs_gl
def test_a_process_that_cannot_begin_leaves_all_to_this_one(
    walk: Walk, alone: list[Pixels], delivered: list[bool], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = tmp_path / "python"
    broken.write_text("#!/bin/sh\nexit 3\n")
    broken.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(broken))
    with drawn(walk, film(walk, 8), 2) as (_, frames):
        assert_same(list(frames), alone)
    assert delivered == [False] * 4


@pytest.mark.slow
@needs_gl
def test_what_a_process_that_ends_too_early_leaves_is_drawn_by_this_one(
    walk: Walk, alone: list[Pixels], delivered: list[bool], monkeypatch: pytest.MonkeyPatch
) -> None:
    started: list[subprocess.Popen[bytes]] = []

    class Kept(subprocess.Popen[bytes]):
        def __init__(self, *arguments: Any, **settings: Any) -> None:
            super().__init__(*arguments, **settings)
            started.append(self)

    ensure_gl()  # which runs processes, too
    monkeypatch.setattr(subprocess, "Popen", Kept)
    with drawn(walk, film(walk, 8), 2) as (_, frames):
        begun = [next(frames), next(frames)]
        started[0].kill()
        started[0].wait()
        assert_same([*begun, *frames], alone)
    assert delivered[0]
    assert not delivered[-1] or delivered == [True] * 4  # it may have sent all of these small frames before


@pytest.mark.slow
@needs_gl
def test_a_reference_that_only_this_process_finds_is_on_every_frame(
    walk: Walk, alone: list[Pixels], monkeypatch: pytest.MonkeyPatch
) -> None:
    received = sharing._received
    blank = bytes(160 * 240 * 3)
    monkeypatch.setattr(sharing, "_received", lambda process, size: b"\0" + blank if received(process, size) else b"")
    with drawn(walk, film(walk, 8), 2) as (stage, frames):
        assert stage.tracks
        assert_same(list(frames), alone)


@pytest.mark.slow
@needs_gl
def test_controllers_without_a_reference_share_their_frames(delivered: list[bool]) -> None:
    walk = mjbiped.walk(PassiveController(), Terrain.incline(2.0), steps=2)
    with drawn(walk, film(walk, 4), 2) as (stage, frames):
        assert not stage.tracks
        assert len(list(frames)) == 4
    assert delivered == [True, True]


def test_short_films_are_drawn_by_one_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sharing, "cores", lambda: 2)
    assert [processes_for(frames) for frames in (1, 399, 400, 9000)] == [1, 1, 2, 2]
    monkeypatch.setattr(sharing, "cores", lambda: 64)
    assert processes_for(9000) == 4
    monkeypatch.setattr(sharing, "cores", lambda: 1)
    assert processes_for(9000) == 1
