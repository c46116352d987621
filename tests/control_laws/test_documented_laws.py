"""The controllers that the pages show are whole programs and files: each walks as its page says."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from command_line import run

import mjbiped
from mjbiped.control.own import own_class

ROOT = Path(__file__).parents[2]


def blocks(page: str, heading: str, language: str = "python") -> list[str]:
    """Blocks of code of a page's section."""
    (section,) = re.findall(rf"^## {re.escape(heading)}$(.*?)(?=^## |\Z)", (ROOT / page).read_text(), re.M | re.S)
    return re.findall(rf"^```{language}\n(.*?)^```$", section, re.M | re.S)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The working directory, with the files of docs/controller.md."""
    (spread,) = blocks("docs/controller.md", "By name on the command line")
    (compiled,) = blocks("docs/controller.md", "What plain Python costs, and the same law compiled")
    (tmp_path / "spread.py").write_text(spread)
    (tmp_path / "spread_compiled.py").write_text(compiled)
    (tmp_path / "trail.csv").write_text("x,z\n-5,0.1746\n0,0\n40,-1.397\n")
    monkeypatch.chdir(tmp_path)
    path = [*sys.path]
    yield tmp_path
    sys.path[:] = path
    sys.modules.pop("spread_compiled", None)


@pytest.mark.usefixtures("folder")
def test_plain_and_compiled_are_one_law() -> None:
    """Bitwise in MuJoCo; to rounding in the hybrid engine, whose compiled code contracts products and sums."""
    # as a module: its name, and what is kept of its machine code, do not depend on the temporary folder
    plain, compiled = (own_class(name)() for name in ("spread.py:HipSpread", "spread_compiled:HipSpread"))
    terrain = mjbiped.Terrain.incline(2.0)
    one, other = (mjbiped.walk(each, terrain, steps=3) for each in (plain, compiled))
    assert one.outcome == "finished"
    assert {name: column.tobytes() for name, column in one.samples.items()} == {
        name: column.tobytes() for name, column in other.samples.items()
    }
    one, other = (mjbiped.walk(each, terrain, engine="hybrid", steps=3) for each in (plain, compiled))
    assert (one.settings["compiled"], other.settings["compiled"]) == (False, True)
    np.testing.assert_allclose(one.touchdowns["q"], other.touchdowns["q"], rtol=0.0, atol=1e-12)  # measured: 1e-15


def commands(page: str, heading: str) -> list[str]:
    return [line for block in blocks(page, heading, "sh") for line in block.splitlines()]


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("command", commands("docs/controller.md", "By name on the command line"))
def test_commands_of_the_page_run(command: str) -> None:
    words = command.split()[1:]
    result = run(*words, *(() if "--steps" in words else ("--steps", "3")))
    assert result.exit_code == 0, result.output


@pytest.mark.parametrize(
    ("page", "heading"), [("README.md", "Your own controller"), ("docs/controller.md", "A controller of your own")]
)
def test_programs_of_the_pages_run(page: str, heading: str, capsys: pytest.CaptureFixture[str]) -> None:
    (program,) = blocks(page, heading)
    exec(compile(program, page, "exec"), {"__name__": "__main__"})
    said = capsys.readouterr().out
    if page == "README.md":
        assert said.startswith("finished")
    else:
        assert said in (ROOT / page).read_text(), "the page shows what it prints"
