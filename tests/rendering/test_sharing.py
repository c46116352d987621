"""Frames that several processes draw are those that one draws, whatever becomes of the others."""

import sys
from pathlib import Path

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.errors import RenderError
from mjbiped.records.record import Walk
from mjbiped.rendering import sharing
from mjbiped.rendering.gl import gl_available
from mjbiped.rendering.look import look
from mjbiped.rendering.overlay import Pixels
from mjbiped.rendering.sharing import drawn, processes_for
from mjbiped.rendering.stage import Film
from mjbiped.robots.compass import Compass
from mjbiped.terrain.terrain import Terrain

needs_gl = pytest.mark.skipif(gl_available() is None, reason="no OpenGL platform")


class Patient(sharing._Painter):
    """One that notes which frames it is asked for."""

    asked: list[int]

    def receive(self, number: int) -> Pixels:
        self.asked.append(number)
        return super().receive(number)


@pytest.fixture
def painters(monkeypatch: pytest.MonkeyPatch) -> list[Patient]:
    started: list[Patient] = []

    class Kept(Patient):
        def __init__(self, folder: Path, film: Film, number: int) -> None:
            super().__init__(folder, film, number)
            self.asked = []
            started.append(self)

    monkeypatch.setattr(sharing, "_Painter", Kept)
    return started


@pytest.fixture(scope="module")
def walk() -> Walk:
    gait = mjbiped.find_passive_gait(Compass(), slope=np.deg2rad(2))
    return mjbiped.walk(AdaptiveController(Compass(), gait), Terrain.stairs(tread=1.0, rise=0.01), steps=4)


def film(walk: Walk, frames: int) -> Film:
    return Film(160, 240, "track", look("chart"), 0.0, walk.end[0], 1.0, round(frames / walk.end[0]), frames)


@needs_gl
@pytest.mark.parametrize("processes", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_frames_are_those_of_one_process(walk: Walk, painters: list[Patient], processes: int) -> None:
    wanted = film(walk, 8)
    with drawn(walk, wanted, 1) as (_, frames):
        alone = list(frames)
    with drawn(walk, wanted, processes) as (_, frames):
        shared = list(frames)
    assert [painter.asked for painter in painters] == [
        [number for number in range(8) if number % processes == turn] for turn in range(1, processes)
    ]
    assert len(shared) == len(alone) == 8
    for one, other in zip(alone, shared, strict=True):
        np.testing.assert_array_equal(one, other)
    assert not np.array_equal(alone[0], alone[4])


@needs_gl
def test_a_process_that_cannot_begin_leaves_all_to_this_one(
    walk: Walk, painters: list[Patient], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = tmp_path / "python"
    broken.write_text("#!/bin/sh\nexit 3\n")
    broken.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(broken))
    with drawn(walk, film(walk, 3), 2) as (_, frames):
        assert len(list(frames)) == 3
    assert painters[0].asked == []


@pytest.mark.slow
@needs_gl
def test_a_process_that_ends_too_early_is_told_of(walk: Walk, painters: list[Patient]) -> None:
    with drawn(walk, film(walk, 40), 2) as (_, frames):
        next(frames)
        painters[0]._process.kill()
        with pytest.raises(RenderError, match=r"process that drew frame \d+ ended with status -9: no word"):
            list(frames)


@pytest.mark.slow
@needs_gl
def test_a_reference_that_only_this_process_finds_is_on_every_frame(
    walk: Walk, painters: list[Patient], monkeypatch: pytest.MonkeyPatch
) -> None:
    answer = sharing._Painter.answer
    monkeypatch.setattr(sharing._Painter, "answer", lambda painter: {b"y": b"n"}[answer(painter)])
    with drawn(walk, film(walk, 3), 2) as (stage, frames):
        assert stage.tracks
        assert len(list(frames)) == 3
    assert painters[0].asked == []


@pytest.mark.slow
@needs_gl
def test_controllers_without_a_reference_share_their_frames(painters: list[Patient]) -> None:
    walk = mjbiped.walk(PassiveController(), Terrain.incline(2.0), steps=2)
    with drawn(walk, film(walk, 4), 2) as (stage, frames):
        assert not stage.tracks
        assert len(list(frames)) == 4
    assert painters[0].asked == [1, 3]


def test_short_films_are_drawn_by_one_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sharing, "cores", lambda: 2)
    assert [processes_for(frames) for frames in (1, 399, 400, 9000)] == [1, 1, 2, 2]
    monkeypatch.setattr(sharing, "cores", lambda: 64)
    assert processes_for(9000) == 4
    monkeypatch.setattr(sharing, "cores", lambda: 1)
    assert processes_for(9000) == 1
