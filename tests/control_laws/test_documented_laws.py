"""The controllers that the pages show are whole programs and files: each walks as its page says."""

import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from command_line import run
from documentation import blocks

import mjbiped
from mjbiped.control.loading import own_class

PAGE = "docs/controller.md"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The working directory, with the files of docs/controller.md."""
    for block in blocks(PAGE):
        if block.file:
            (tmp_path / block.file).write_text(block.code)
    (tmp_path / "trail.csv").write_text("x,z\n-5,0.1746\n0,0\n40,-1.397\n")
    monkeypatch.chdir(tmp_path)
    path = [*sys.path]
    yield tmp_path
    sys.path[:] = path
    sys.modules.pop("spread_compiled", None)


@pytest.mark.slow
@pytest.mark.compiled
@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
@pytest.mark.usefixtures("folder")
def test_plain_and_compiled_are_one_law(engine: str) -> None:
    """Bit by bit."""
    # as a module: its name, and what is kept of its machine code, do not depend on the temporary folder
    plain, compiled = (own_class(name)() for name in ("spread.py:HipSpread", "spread_compiled:HipSpread"))
    terrain = mjbiped.Terrain.incline(2.0)
    one, other = (mjbiped.walk(each, terrain, engine=engine, steps=3) for each in (plain, compiled))
    assert one.outcome == "finished"
    assert replace(other, settings=one.settings) == one


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    "command", [line for block in blocks(PAGE) if block.language == "sh" for line in block.code.splitlines()]
)
def test_commands_of_the_page_run(command: str) -> None:
    words = command.split()[1:]
    result = run(*words, *(() if "--steps" in words else ("--steps", "3")))
    assert result.exit_code == 0, result.output
