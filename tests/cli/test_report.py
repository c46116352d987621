"""`mjbiped report`: what it writes, and what it refuses."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from command_line import run

import mjbiped
from controllers import AdaptiveController


@pytest.fixture
def record(controller: AdaptiveController, tmp_path: Path) -> Path:
    path = tmp_path / "walk.npz"
    mjbiped.walk(controller, mjbiped.Terrain.level(), engine="hybrid", steps=2).save(path)
    return path


@pytest.mark.slow
def test_the_page_stands_beside_the_record_or_where_it_shall(record: Path, tmp_path: Path) -> None:
    result = run("report", record, "--no-video")
    assert result.exit_code == 0, result.stderr
    assert result.stdout == f"wrote {tmp_path / 'walk.html'}\n"
    other = run("report", record, "--no-video", "--out", tmp_path / "other.html", "--quiet")
    assert (other.exit_code, other.stdout) == (0, "")
    assert (tmp_path / "other.html").read_bytes() == (tmp_path / "walk.html").read_bytes()


@pytest.mark.usefixtures("studies_in_threads")
def test_a_sweeps_folder_has_a_page_too(tmp_path: Path) -> None:
    study = tmp_path / "study.toml"
    study.write_text('engine = "hybrid"\nsteps = 2\ncontroller = { position_gain = [3, 6] }\n')
    assert run("sweep", study).exit_code == 0
    result = run("report", tmp_path / "study")
    assert result.exit_code == 0, result.stderr
    assert (tmp_path / "study" / "report.html").exists()
    refused = run("report", tmp_path / "study", "--no-video")
    assert (refused.exit_code, "--no-video" in refused.stderr) == (2, True)


def test_what_is_no_record_is_refused(tmp_path: Path, record: Path) -> None:
    (tmp_path / "heights.toml").write_text("steps = 2\n")
    for words, said in (
        ((tmp_path / "heights.toml",), f"expected is the folder of its sweep, which is {tmp_path / 'heights'} unless"),
        ((tmp_path / "none.npz",), "there is no"),
        ((tmp_path,), "holds no study.sqlite"),
        ((record, "--out", tmp_path / "page.pdf"), ".html"),
        ((record, "--out", tmp_path / "nowhere" / "page.html"), "make it first"),
    ):
        result = run("report", *words)
        assert result.exit_code == 2
        assert said in result.stderr
    record.write_bytes(b"broken")
    result = run("report", record)
    assert result.exit_code == 2
    assert "no walk's record" in result.stderr


@pytest.mark.parametrize(("module", "name"), [("plotly", "Plotly"), ("jinja2", "Jinja")])
def test_without_the_extra_it_is_named(
    module: str, name: str, record: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    result = run("report", record)
    assert result.exit_code == 2
    assert f"{name}, which is not installed: pip install 'mjbiped[report]'" in result.stderr
    assert not (tmp_path / "walk.html").exists()
