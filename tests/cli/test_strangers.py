"""Records that come from anyone: whatever they say, no command runs code of theirs, nor computes for minutes."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
from command_line import run

import mjbiped
from controllers import AdaptiveController
from mjbiped.control.loading import digest_of
from mjbiped.gaits import optimised
from mjbiped.gaits.described import gait_from
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
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The working directory, with a controller that leaves a trace where it is loaded."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    (tmp_path / "mine.py").write_text(MINE)
    yield tmp_path
    sys.modules.pop("mine", None)


def with_settings(walk: mjbiped.Walk, **settings: Any) -> mjbiped.Walk:
    return dataclasses.replace(walk, settings={**walk.settings, **settings})


def source(place: str, digest: str | None = None) -> Mapping[str, str]:
    return {"class": place, "sha256": digest_of(place) if digest is None else digest}


@pytest.fixture
def walk(controller: AdaptiveController) -> mjbiped.Walk:
    return mjbiped.walk(controller, mjbiped.Terrain.mixed(), engine="hybrid", steps=1, initial="rest")


@pytest.mark.parametrize(("place", "true"), [("mine.py:Mine", False), ("mine:Mine", True)])
def test_no_record_decides_what_code_is_loaded(folder: Path, walk: mjbiped.Walk, place: str, *, true: bool) -> None:
    described = {**walk.settings["controller"], "name": "Mine"}
    told = source(place) if true else source(place, "0" * 64)
    with_settings(walk, controller=described, controller_source=told).save(folder / "walk.npz")
    for words in (
        ("report", "walk.npz", "--no-video"),
        ("render", "walk.npz", "--no-video", "--plot", "walk.png"),
        ("stability", "walk.npz"),
    ):
        result = run(*words)
        assert (result.exit_code == 2) == (words[0] == "stability"), result.stderr
        assert not (folder / "ran").exists(), words
    assert "name it yourself: --controller FILE.py:CLASS" in result.stderr
    if not true:
        named = run("stability", "walk.npz", "--controller", place)
        assert (named.exit_code, "is another one" in named.stderr) == (2, True)
        assert not (folder / "ran").exists()


def test_a_law_that_the_user_names_is_evaluated(folder: Path, walk: mjbiped.Walk) -> None:
    described = {**walk.settings["controller"], "name": "Mine"}
    walked = with_settings(walk, controller=described, controller_source=source("mine.py:Mine"))
    walked.save(folder / "walk.npz")
    (folder / "elsewhere").mkdir()
    (folder / "mine.py").rename(folder / "elsewhere" / "mine.py")  # the digest tells a source, wherever it lies
    result = run("stability", "walk.npz", "--controller", "elsewhere/mine.py:Mine", "--json")
    assert result.exit_code == 0, result.stderr
    assert (folder / "elsewhere" / "ran").exists()
    for words, said in (
        (("--controller", "adaptive"), "'adaptive' is another class"),
        (("--controller", "elsewhere/mine.py:Other"), "is another class"),
    ):
        refused = run("stability", "walk.npz", *words)
        assert (refused.exit_code, said in refused.stderr) == (2, True), refused.stderr
    walk.save(folder / "plain.npz")
    refused = run("stability", "plain.npz", "--controller", "elsewhere/mine.py:Mine")
    assert (refused.exit_code, "no class of yours is needed" in refused.stderr) == (2, True)


def test_a_report_searches_for_no_reference(walk: mjbiped.Walk, monkeypatch: pytest.MonkeyPatch) -> None:
    goal = {"speed": 0.513, "clearance": 0.07, "retraction": True, "torque_limit": None, "friction": 0.6}
    gait = {
        "goal": goal,
        "clearance_phase": 0.8,
        "half_angle": 0.2,
        "control_points": [[0.0, 0.1]] * (DEGREE - 2),
        "robot": walk.settings["robot"],
    }
    described = walk.settings["controller"]
    library = {
        **{key: value for key, value in described.items() if key != "name"},
        **{"name": "LibraryController", "replanning": "additive", "gait": gait},
        **{"climbing_clearance": 0.1, "climbing_steps": 5, "height_threshold": 0.005},
    }
    monkeypatch.setattr(optimised, "optimise", lambda *_: pytest.fail("a reference was searched for"))
    for controller in ({**described, "gait": gait}, library):
        odd = with_settings(walk, controller=controller)
        assert walk_figures(odd, video=False)


ODD_GAITS: tuple[dict[str, Any], ...] = (
    {"goal": {"speed": 1e-300}},
    {"goal": {"speed": "fast"}},
    {"half_angle": 0.0},
    {"clearance_phase": "late"},
    {"control_points": [[1.0]]},
    {"robot": {"leg_mass": [1]}},
)


@pytest.mark.parametrize("odd", ODD_GAITS)
def test_gaits_that_are_none_are_left_out_of_pictures(controller: AdaptiveController, odd: dict[str, Any]) -> None:
    sound: dict[str, Any] = {
        "goal": {"speed": 0.5, "clearance": 0.06, "retraction": True, "torque_limit": None, "friction": 0.6},
        "clearance_phase": 0.8,
        "half_angle": 0.2,
        "control_points": [[0.0, 0.1]] * (DEGREE - 2),
        "robot": controller.robot.to_dict(),
    }
    assert gait_from(sound).period > 0.0
    changed = {**sound, **odd, **({"goal": {**sound["goal"], **odd["goal"]}} if "goal" in odd else {})}
    with pytest.raises(mjbiped.InputError):
        gait_from(changed)
