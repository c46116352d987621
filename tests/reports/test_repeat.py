"""How a walk is made again: a record has the command that made it, which gives the same record."""

from __future__ import annotations

import shlex
from pathlib import Path

from command_line import run

import mjbiped
from controllers import AdaptiveController


def test_a_record_has_the_command_that_made_it(tmp_path: Path) -> None:
    words = ["random:seed=3,slope_deg=-1..2", "--engine", "hybrid", "--steps", "2", "--initial", "rest", "--quiet"]
    one, other = tmp_path / "it's.npz", tmp_path / "again.npz"
    assert run("walk", *words, "--out", one).exit_code == 0
    walk = mjbiped.Walk.load(one)
    assert walk.settings["command"] == shlex.join(["mjbiped", "walk", *words, "--out", str(one)])
    again = shlex.split(walk.settings["command"].replace(shlex.quote(str(one)), str(other)))
    assert run(*again[1:]).exit_code == 0
    assert mjbiped.Walk.load(other) == walk


def test_a_walk_of_a_program_has_no_command(controller: AdaptiveController) -> None:
    walk = mjbiped.walk(controller, mjbiped.Terrain.level(), engine="hybrid", steps=1)
    assert "command" not in walk.settings
