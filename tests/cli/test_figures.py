"""`mjbiped figures`: the whole set, by the commands that draw each."""

from __future__ import annotations

import json
from pathlib import Path

import click
import pytest
from command_line import assert_refused, run

from mjbiped.cli import export as figures
from mjbiped.cli.main import main

CHEAP = {"gait": "gait --slope-deg 2", "wheel": "return-map --robot wheel --slope-deg 5 --points 20"}


@pytest.fixture
def cheap(monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    shown = dict(CHEAP)
    monkeypatch.setattr(figures, "SET", shown)
    return shown


@pytest.mark.slow
def test_figures_are_files_of_their_names_and_the_summary_tells_their_commands(
    cheap: dict[str, str], tmp_path: Path
) -> None:
    folder = tmp_path / "for slides"
    result = run("figures", folder, "--plot-width", "single")
    assert result.exit_code == 0, result.stderr
    for name, command in cheap.items():
        pdf = folder / f"{name}.pdf"
        assert pdf.read_bytes().startswith(b"%PDF")
        assert f"mjbiped {command} --plot '{pdf}'" in result.stdout
        assert f"wrote {pdf}" in result.stdout


@pytest.mark.slow
def test_figures_as_json_and_in_silence(cheap: dict[str, str], tmp_path: Path) -> None:
    printed = json.loads(run("figures", tmp_path, "--json", "--quiet").stdout)
    assert [each["command"].split()[1] for each in printed["figures"]] == ["gait", "return-map"]
    assert printed["files"] == {f"{name}.pdf": str(tmp_path / f"{name}.pdf") for name in cheap}
    assert run("figures", tmp_path, "--quiet").output == ""


@pytest.mark.slow
def test_one_that_fails_does_not_stop_the_others(cheap: dict[str, str], tmp_path: Path) -> None:
    cheap.clear()
    cheap.update({"steep": "gait --slope-deg 80", **CHEAP})
    result = run("figures", tmp_path, "--quiet")
    assert result.exit_code == 2
    assert "Error: no passive gait on a slope of 80 degrees" in result.stderr
    assert "mjbiped gait failed" in result.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["gait.pdf", "wheel.pdf"]


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    assert_refused(run("figures", tmp_path / "file" / "folder"), "cannot be made: Not a directory; give another folder")


@pytest.mark.slow
def test_ctrl_c_keeps_the_figures_before(
    cheap: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(main.commands["return-map"], "callback", interrupted)
    cheap["never"] = "gait --slope-deg 1"
    result = run("figures", tmp_path, "--quiet")
    assert result.exit_code == 130
    assert "interrupted in mjbiped return-map" in result.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["gait.pdf"]


@pytest.mark.parametrize("name", figures.SET)
def test_the_commands_of_the_set_can_be_read(name: str, tmp_path: Path) -> None:
    word, *words = figures.SET[name].format(folder=tmp_path).split()
    context = main.commands[word].make_context(word, [*words, "--plot", str(tmp_path / f"{name}.pdf"), "--quiet"])
    assert isinstance(context, click.Context)


@pytest.mark.slow
def test_the_whole_set(tmp_path: Path) -> None:
    """Some minutes; all of it, as it is given to people."""
    result = run("figures", tmp_path, "--quiet")
    assert result.exit_code == 0, result.stderr
    assert {f"{name}.pdf" for name in figures.SET} <= {path.name for path in tmp_path.iterdir()}
