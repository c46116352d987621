"""`mjbiped return-map`, `bifurcation` and `basin`: what they print and write, refuse, and their exit status."""

from __future__ import annotations

import json
from concurrent.futures import as_completed
from pathlib import Path

import numpy as np
import pytest
from command_line import run

from mjbiped.limit_cycles import basin
from mjbiped.limit_cycles.basin import Fate

SMALL = ("--slopes", 24, "--steps", 60, "--keep", 12, "--doublings", 2)


@pytest.mark.slow
def test_return_map_tells_the_gait_and_writes_its_files(tmp_path: Path) -> None:
    paths = [tmp_path / name for name in ("map.npz", "map.png")]
    result = run("return-map", "--slope-deg", 3, "--points", 40, "--out", paths[0], "--plot", paths[1])
    assert result.exit_code == 0
    for text in (
        "angle of the stance leg (rad)",
        "multipliers",
        "settled period",
        *map(str, paths),
    ):
        assert text in result.stdout
    with np.load(paths[0]) as data:
        assert data["before"].shape == data["after"].shape == (3, 40)
        assert data["walk"].shape == (41, 3)
    assert paths[1].stat().st_size > 10_000


@pytest.mark.slow
def test_return_map_of_a_wheel_as_json() -> None:
    printed = json.loads(run("return-map", "--robot", "wheel", "--slope-deg", 5, "--json").stdout)
    assert printed["fixed_point"] == {"rate of the stance spoke (rad/s)": pytest.approx(1.144017, abs=1e-6)}
    assert printed["multipliers"] == [[pytest.approx(0.5), 0.0]]
    assert (printed["settled_period"], printed["files"]) == (1, {})


@pytest.mark.slow
def test_bifurcation_tells_the_onsets_and_writes_its_files(tmp_path: Path) -> None:
    paths = [tmp_path / name for name in ("data.npz", "diagram.png", "multipliers.pdf")]
    words = ("--out", paths[0], "--plot", paths[1], "--plot-multipliers", paths[2])
    # on 3.6 degrees only three of four starts are lost within 60 steps, and rounding decides which; on 3.7 all are
    result = run("bifurcation", *SMALL, *words, "--slope-deg", "2.4..3.7")
    assert result.exit_code == 0
    for text in ("2.72844", "3.2986", "lost", *map(str, paths)):
        assert text in result.stdout.replace("\n", "")
    with np.load(paths[0]) as data:
        assert data["states"].shape == (len(data["slopes"]), 12, 4)
        assert np.degrees(data["onsets"]) == pytest.approx([2.72844, 3.29863], abs=1e-5)
    assert paths[1].stat().st_size > 10_000
    assert paths[2].stat().st_size > 5_000


@pytest.mark.slow
def test_bifurcation_as_json() -> None:
    result = run("bifurcation", *SMALL, "--json", "--leg-inertia", 0, "--hip-mass", 10, "--slope-deg", "4..5")
    printed = json.loads(result.stdout)
    assert printed["onsets_deg"][0] == pytest.approx(4.3909, abs=5e-5)
    assert printed["lost_deg"] is None
    assert printed["files"] == {}


@pytest.mark.slow
def test_bifurcation_with_knees(tmp_path: Path) -> None:
    """From before the first doubling to beyond the first fall, without being told where they are."""
    words = ("--json", "--plot", tmp_path / "diagram.png", "--plot-multipliers", tmp_path / "multipliers.png")
    printed = json.loads(run("bifurcation", "--robot", "kneed", "--sole", 0.1, *SMALL, *words).stdout)
    assert printed["onsets_deg"] == pytest.approx([5.683, 6.2126], abs=1e-3)
    assert 6.5 < printed["lost_deg"] < 6.7
    assert set(printed["files"]) == {"plot", "multipliers"}


@pytest.mark.slow
def test_basin_tells_the_shares_and_writes_its_files(tmp_path: Path) -> None:
    paths = [tmp_path / name for name in ("data.npz", "basin.png")]
    result = run("basin", "--grid", 12, "--out", paths[0], "--plot", paths[1], "--threads", 1)
    assert result.exit_code == 0
    for text in ("settled", "fell", "144", *map(str, paths)):
        assert text in result.stdout.replace("\n", "")
    with np.load(paths[0]) as data:
        assert data["fates"].shape == data["steps"].shape == (12, 12)
        assert data["fate_names"][0] == "settled"


@pytest.mark.slow
def test_basin_with_knees(tmp_path: Path) -> None:
    words = ("--slope-deg", 2.5, "--grid", 6, "--threads", 1, "--json", "--plot", tmp_path / "basin.png")
    printed = json.loads(run("basin", "--robot", "kneed", *words).stdout)
    assert (printed["walker"], printed["starts"]) == ("passive", 36)
    assert 0.0 < printed["shares"]["settled"] < 1.0
    refused = run("basin", "--robot", "kneed", "--scuffing-reach", 0.3)
    assert refused.exit_code == 2
    assert "scuffing is for straight legs" in refused.stderr


def test_controlled_basin_as_json() -> None:
    words = ("--stance-rates", "0..2", "--swing-rates=-1..1", "--grid", 3)
    printed = json.loads(run("basin", "--controller", "adaptive", *words, "--json").stdout)
    assert printed["walker"] == "AdaptiveController"
    assert printed["slope_deg"] == 0.0
    assert printed["shares"]["settled"] == 1.0
    assert printed["starts"] == 9


def test_interrupted_basin_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(futures: list[object]) -> object:
        next(as_completed(futures))  # type: ignore[arg-type,var-annotated,unused-ignore]
        raise KeyboardInterrupt
        yield

    monkeypatch.setattr(basin, "as_completed", interrupted)
    path = tmp_path / "data.npz"
    result = run("basin", "--grid", 200, "--out", path, "--quiet", "--threads", 1)
    assert result.exit_code == 130
    assert "interrupted" in result.stderr
    with np.load(path) as data:
        assert 0 < (data["fates"] != Fate.UNDECIDED).any(axis=1).sum() < 200


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("return-map", "--slope-deg", "-1"), "downhill"),
        (("return-map", "--robot", "kneed", "--scuffing-reach", "0.3"), "scuffing is for straight legs"),
        (("bifurcation", "--slope-deg", "3"), "LOW..HIGH"),
        (("bifurcation", "--slope-deg", "3..2"), "the first below the second"),
        (("bifurcation", "--slope-deg", "0..2"), "slopes must be above 0"),
        (("bifurcation", "--keep", "700"), "more than the 600 steps"),
        (("bifurcation", "--doublings", "9"), "doublings"),
        (("bifurcation", "--leg-mass", "-1"), "'--leg-mass'"),
        (("bifurcation", "--leg-inertia", "50"), "no passive gait"),
        (("bifurcation", "--robot", "wheel"), "no swing leg"),
        (("bifurcation", "--robot", "kneed", "--scuffing-reach", "0.3"), "scuffing is for straight legs"),
        (("bifurcation", "--thigh-mass", "3"), "--robot kneed"),
        (("basin", "--slope-deg", "-2"), "downhill"),
        (("basin", "--slope-deg", "nan"), "89.95 degrees"),
        (("basin", "--swing-rates", "a..b"), "LOW..HIGH"),
        (("basin", "--grid", "1"), "grid"),
        (("basin", "--limit", "0"), "limit"),
        (("basin", "--out", "data.csv"), ".npz"),
        (("basin", "--plot", "map.gif"), ".png"),
    ],
)
def test_bad_input_is_refused(words: tuple[str, ...], message: str) -> None:
    result = run(*words)
    assert result.exit_code == 2
    assert message in result.stderr.replace("\n", " ")
    assert "Traceback" not in result.stderr
