"""Controllers of one's own on the command line: walked by name, their fields set, what is wrong told in one line."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import own_controllers
import pytest
from command_line import assert_refused, run

from mjbiped.control.registry import controller_names
from mjbiped.records.record import Walk

TRAIL = "x,z\n-5,0.17461\n0,0\n40,-1.39685\n"
"""An own CSV: 2 degrees downhill."""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """An empty working directory but for a terrain and controllers."""
    monkeypatch.chdir(tmp_path)
    own_controllers.write(tmp_path, "trail.csv", TRAIL)
    own_controllers.write(tmp_path, "spread.py", own_controllers.SPREAD)
    own_controllers.write(tmp_path, "imitating.py", own_controllers.IMITATING)
    path = [*sys.path]
    yield tmp_path
    sys.path[:] = path


@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_a_class_in_a_file_walks_on_a_csv(engine: str) -> None:
    words = ("--controller", "spread.py:HipSpread", "--gain", "stiffness=0.45", "--steps", 2, "--out", "walk.npz")
    result = run("walk", "trail.csv", "--engine", engine, *words, "--quiet")
    assert (result.exit_code, result.output) == (0, "")
    walk = Walk.load(Path("walk.npz"))
    assert walk.outcome == "finished"
    assert walk.settings["controller"] == {"name": "HipSpread", "stiffness": 0.45, "spread": 0.4}
    assert walk.settings["controller_source"]["class"] == "spread.py:HipSpread"


def test_one_that_imitates_a_gait_takes_the_gaits_options() -> None:
    words = ("--controller", "imitating.py:Imitating", "--imitate-slope-deg", 1.5, "--hip-mass", 3, "--steps", 1)
    result = run("walk", "trail.csv", "--engine", "hybrid", *words, "--out", "walk.npz", "--quiet")
    assert result.exit_code == 0, result.output
    law = Walk.load(Path("walk.npz")).settings["controller"]
    assert law["gait"]["slope"] == pytest.approx(0.0261799388)
    assert law["robot"]["hip_mass"] == 3.0


def test_compare_walks_it_in_both_engines() -> None:
    result = run("compare", "trail.csv", "--controller", "spread.py:HipSpread", "--steps", 2, "--out", "both.npz")
    assert result.exit_code == 0, result.output
    assert "HipSpread on trail.csv" in result.stdout
    assert Path("both_mujoco.npz").is_file()
    assert Path("both_hybrid.npz").is_file()


def test_a_comparison_that_fails_keeps_what_was_walked() -> None:
    """Of a law that fails between the milliseconds at which MuJoCo asks for it, until the foot is about to land."""
    body = "if 0.0 < t < 0.3 and abs(1e3 * t - round(1e3 * t)) > 1e-6:\n    raise KeyError('gone')\nreturn 0.0, 0.0"
    own_controllers.write(Path(), "odd.py", own_controllers.law(body))
    result = run("compare", "trail.csv", "--controller", "odd.py:Law", "--steps", 1, "--out", "both.npz")
    assert (result.exit_code, result.stdout) == (1, "wrote both_mujoco.npz\nwrote both_hybrid.npz\n")
    assert "Law failed at 0.0" in result.stderr
    assert "odd.py, line 7, in torque: raise KeyError('gone')) (engine hybrid); what was walked is in" in result.stderr
    outcomes = [Walk.load(Path(f"both_{engine}.npz")).outcome for engine in ("mujoco", "hybrid")]
    assert outcomes == ["finished", "interrupted"]


def test_basin_maps_what_imitates_a_gait_and_refuses_what_does_not() -> None:
    result = run(
        "basin", "--controller", "imitating.py:Imitating", "--slope-deg", 2, "--grid", 2, "--limit", 1, "--json"
    )
    assert result.exit_code == 0, result.output
    assert '"walker": "Imitating"' in result.stdout
    assert_refused(run("basin", "--controller", "spread.py:HipSpread"), "HipSpread imitates no gait")
    assert_refused(run("basin", "--imitate-slope-deg", 3), "controller passive 'imitate_slope_deg'")


def test_a_basin_that_fails_is_written() -> None:
    text = own_controllers.IMITATING.replace(
        "        wanted", "        if t > 0.1:\n            raise KeyError('gone')\n        wanted"
    )
    own_controllers.write(Path(), "failing.py", text)
    result = run("basin", "--controller", "failing.py:Imitating", "--grid", 2, "--out", "basin.npz", "--quiet")
    assert result.exit_code == 1
    assert "Imitating failed in the walk from the rates" in result.stderr
    assert "failing.py, line" in result.stderr
    assert Path("basin.npz").is_file()


def test_the_adaptive_controller_has_gains_too() -> None:
    words = ("--gain", "position_gain=7", "--gain", "replanning_delay=none", "--gain", "estimate_update=false")
    result = run("walk", "level", "--engine", "hybrid", *words, "--steps", 1, "--out", "walk.npz", "--quiet")
    assert result.exit_code == 0, result.output
    law = Walk.load(Path("walk.npz")).settings["controller"]
    assert (law["position_gain"], law["replanning_delay"], law["estimate_update"]) == (7.0, None, False)


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("--controller", "spread.py:HipSpred"), "did you mean 'HipSpread'"),
        (("--controller", "gone.py:HipSpread"), "there is no such file"),
        (("--controller", "pasive"), "did you mean 'passive'?"),
        (("--controller", "spread.py:HipSpread", "--gain", "k=1"), "valid are stiffness=0.5, spread=0.4"),
        (("--controller", "spread.py:HipSpread", "--gain", "stifness=1"), "did you mean 'stiffness'?"),
        (
            ("--controller", "spread.py:HipSpread", "--gain", "spread=wide"),
            "spread: spread = 'wide': must be a finite",
        ),
        (
            ("--controller", "spread.py:HipSpread", "--imitate-slope-deg", 1),
            "HipSpread 'imitate_slope_deg'",
        ),
        (
            ("--controller", "imitating.py:Imitating", "--position-gain", 1),
            "Imitating 'position_gain'",
        ),
        (("--controller", "passive", "--gain", "k=1"), "controller passive 'k': valid are none"),
        (
            ("--position-gain", 3, "--gain", "position_gain=3"),
            "--position-gain is given, too; give one of them",
        ),
        (("level", "--controller", "spread.py:HipSpread"), 'give initial="rest" (--initial rest)'),
    ],
)
def test_refused_in_one_line(words: tuple[object, ...], reason: str) -> None:
    terrain = () if words[0] == "level" else ("trail.csv",)
    assert_refused(run("walk", *terrain, *words), reason)


def test_what_has_no_law_is_not_compiled() -> None:
    assert_refused(run("compile", "spread.py:HipSpread"), "is plain Python, of which no machine code is made")


def test_options_of_the_adaptive_controller_serve_what_builds_on_it(tmp_path: Path) -> None:
    words = ("walk", "level", "--engine", "hybrid", "--steps", 1, "--controller", "library", "--quiet")
    records = [tmp_path / name for name in ("option.npz", "gain.npz")]
    for record, setting in zip(records, (("--position-gain", 6), ("--gain", "position_gain=6")), strict=True):
        assert run(*words, *setting, "--out", record).exit_code == 0
    walks = [Walk.load(record) for record in records]
    assert walks[0].settings["controller"]["position_gain"] == 6.0
    assert walks[0] == walks[1]


def test_help_tells_the_gains_of_every_controller() -> None:
    told = " ".join(run("walk", "--help").output.split())
    for name in controller_names():
        assert name == "passive" or f"{name}: " in told
    assert "supervised: those, and sole_share=0.95, climbing_clearance=" in told
    assert "policy: none;" in told
    assert "replanning_threshold=0.01" in told
