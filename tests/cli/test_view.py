"""`mjbiped view` where there is no screen, and its mistakes; tests/viewing has the rest."""

from pathlib import Path

import pytest
from command_line import run

import mjbiped
from controllers import AdaptiveController
from mjbiped.cli.walkers import next_ground
from mjbiped.viewing import KEYS


@pytest.fixture(autouse=True)
def no_screen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)


def test_without_a_screen_it_says_so_in_one_line() -> None:
    done = run("view")
    assert done.exit_code == 2
    assert done.stdout == ""
    [line] = done.stderr.splitlines()
    assert "no screen" in line
    assert "mjbiped render" in line


def test_a_screen_that_cannot_be_reached_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DISPLAY", ":9999")
    done = run("view")
    assert done.exit_code == 2
    [line] = done.stderr.splitlines()
    assert "no window can be opened" in line
    assert "mjbiped render" in line


def test_mistakes_are_told_before_the_screen_is_asked_for(tmp_path: Path, controller: AdaptiveController) -> None:
    record = tmp_path / "walk.npz"
    mjbiped.walk(controller, mjbiped.Terrain.level(), steps=2, engine="hybrid").save(record)
    for words, wanted in (
        (("nowhere",), "nowhere"),
        ((tmp_path / "none.npz",), "none.npz"),
        ((record, "--steps", "3"), "--steps is for walks that are made"),
        ((record, "--position-gain", "3"), "--position-gain is for walks that are made"),
        (("mixed", "--seed", "3"), "--seed"),
        (("mixed", "--slow-motion", "0"), "--slow-motion"),
        (("mixed", "--hide", "sky"), "sky"),
    ):
        done = run("view", *words)
        assert done.exit_code == 2
        assert wanted in done.stderr
    assert "no screen" in run("view", record).stderr


def test_the_help_names_every_key() -> None:
    text = run("view", "--help").stdout
    for key in KEYS.values():
        assert key.name in text
        assert key.does in text
    assert "mjpython" in text


def test_grounds_have_the_seeds_after_the_first() -> None:
    for text, seed in (("random:seed=7,length=12", None), ("random:length=12", 7)):
        following = next_ground(text, seed)
        assert following is not None
        assert following() == mjbiped.Terrain.random(seed=8, length=12)
        assert following() == mjbiped.Terrain.random(seed=9, length=12)
    assert next_ground("mixed", None) is None
