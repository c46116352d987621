"""Records that come from anyone: whatever they say, no command runs code of theirs, nor computes for minutes."""

import dataclasses
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import own_controllers
import pytest
from command_line import assert_refused, run

import mjbiped
from mjbiped.control.loading import digest_of
from mjbiped.gaits import optimised
from mjbiped.gaits.reference import DEGREE
from mjbiped.reports.walk import walk_figures

MINE = """\
from pathlib import Path
from controllers import AdaptiveController

Path(__file__).with_name("ran").touch()


class Mine(AdaptiveController):
    pass
"""


@pytest.fixture
def mine(folder: Path) -> Iterator[Path]:
    """The working folder, with a controller that leaves a trace where it is loaded."""
    yield own_controllers.write(folder, "mine.py", MINE)
    sys.modules.pop("mine", None)


def with_settings(walk: mjbiped.Walk, **settings: Any) -> mjbiped.Walk:
    return dataclasses.replace(walk, settings={**walk.settings, **settings})


def by_mine(walk: mjbiped.Walk, place: str, digest: str) -> mjbiped.Walk:
    described = {**walk.settings["controller"], "name": "Mine"}
    return with_settings(walk, controller=described, controller_source={"class": place, "sha256": digest})


@pytest.fixture
def walk(record: Path) -> mjbiped.Walk:
    return mjbiped.Walk.load(record)


@pytest.mark.parametrize(("place", "true"), [("mine.py:Mine", False), ("mine:Mine", True)])
def test_no_record_decides_what_code_is_loaded(mine: Path, walk: mjbiped.Walk, place: str, *, true: bool) -> None:
    by_mine(walk, place, digest_of(place) if true else "0" * 64).save("walk.npz")
    for line in ("report walk.npz --no-video", "render walk.npz --no-video --plot walk.png"):
        assert run(*line.split()).exit_code == 0
    assert_refused(run("stability", "walk.npz"), "name it yourself: --controller FILE.py:CLASS")
    if not true:
        assert_refused(run("stability", "walk.npz", "--controller", place), "is another one")
    assert not mine.with_name("ran").exists()


def test_a_law_that_the_user_names_is_evaluated(mine: Path, walk: mjbiped.Walk) -> None:
    by_mine(walk, "mine.py:Mine", digest_of("mine.py:Mine")).save("mine.npz")
    Path("elsewhere").mkdir()
    mine.rename("elsewhere/mine.py")  # the digest tells a source, wherever it lies
    result = run("stability", "mine.npz", "--controller", "elsewhere/mine.py:Mine", "--json")
    assert result.exit_code == 0, result.stderr
    assert Path("elsewhere/ran").exists()
    for record, named, said in (
        ("mine.npz", "adaptive", "'adaptive' is another class"),
        ("mine.npz", "elsewhere/mine.py:Other", "is another class"),
        ("walk.npz", "elsewhere/mine.py:Mine", "no class of yours is needed"),
    ):
        assert_refused(run("stability", record, "--controller", named), said)


GAIT: dict[str, Any] = {
    "goal": {"speed": 0.513, "clearance": 0.07, "retraction": True, "torque_limit": None, "friction": 0.6},
    "clearance_phase": 0.8,
    "half_angle": 0.2,
    "control_points": [[0.0, 0.1]] * (DEGREE - 2),
    "robot": mjbiped.Compass().to_dict(),
}


def test_a_report_searches_for_no_reference(walk: mjbiped.Walk, monkeypatch: pytest.MonkeyPatch) -> None:
    imitating = {**walk.settings["controller"], "gait": GAIT}
    climbing = {"climbing_clearance": 0.1, "climbing_steps": 5, "height_threshold": 0.005}
    library = {**imitating, "name": "LibraryController", "replanning": "additive", **climbing}
    monkeypatch.setattr(optimised, "optimise", lambda *_: pytest.fail("a reference was searched for"))
    for controller in (imitating, library):
        assert walk_figures(with_settings(walk, controller=controller), video=False)
