"""`mjbiped gait` and `stability`: what they print and write, and refuse."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from command_line import Drawings, assert_refused, run

import mjbiped
from mjbiped.analysis.stability import stability


def test_gait_prints_the_cycle(drawings: Drawings, tmp_path: Path) -> None:
    plot = tmp_path / "gait.pdf"
    result = run("gait", "--slope-deg", 2, "--plot", plot)
    assert (result.exit_code, result.stderr) == (0, "")
    for number in ("-0.19008478", "1.1031758", "0.76484357", "0.377884", "0.494067", "51.31077", "0.27554", "0.53364"):
        assert number in result.stdout
    assert result.stdout.endswith(f"wrote {plot}\n")
    assert drawings.calls == [("plot_gait", {"slope": pytest.approx(math.radians(2))})]


def test_gait_with_knees(tmp_path: Path) -> None:
    plot = tmp_path / "knees.png"
    result = run("gait", "--robot", "kneed", "--slope-deg", 2.5, "--plot", plot)
    assert (result.exit_code, result.stderr) == (0, "")
    for number in ("-0.24447693", "1.0890737", "0.35377631", "0.52706293", "0.61464642", "0.02560", "0.70997", "yes"):
        assert number in result.stdout
    assert result.stdout.endswith(f"wrote {plot}\n")
    assert plot.read_bytes().startswith(b"\x89PNG")


def test_gait_with_knees_as_json_is_the_gait() -> None:
    result = run("gait", "--robot", "halved-rods", "--slope-deg", 5.5, "--json")
    printed = json.loads(result.stdout)
    gait = mjbiped.find_kneed_gait(mjbiped.KneedBiped.halved_rods(), math.radians(5.5))
    assert printed["state_after_heel_strike"] == gait.start.tolist()
    assert printed["state_before_heel_strike"] == gait.end.tolist()
    assert printed["rates_before_knee_strike"] == gait.knee_rates.tolist()
    assert (printed["knee_strike_s"], printed["period_s"]) == (gait.knee_strike, gait.period)
    assert (printed["clearance_m"], printed["step_length_m"]) == (gait.clearance, gait.step_length)
    assert [each["modulus"] for each in printed["multipliers"]] == pytest.approx(abs(gait.multipliers))
    assert printed["stable"] is True


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (
            ("--robot", "kneed", "--leg-mass", 4),
            "--leg-mass is for --robot compass, footed, round; kneed has no such thing.",
        ),
        (("--robot", "kneed", "--slope-deg", -1), "walks only downhill"),
        (
            ("--robot", "knee"),
            "unknown robot 'knee'",
        ),
    ],
)
def test_what_a_gait_with_knees_does_not_take(words: tuple[object, ...], reason: str) -> None:
    result = run("gait", *words)
    assert result.exit_code == 2
    assert reason in " ".join(result.stderr.split())


def test_gait_as_json_is_the_gait() -> None:
    result = run("gait", "--slope-deg", 3.6, "--hip-mass", 5, "--json")
    printed = json.loads(result.stdout)
    gait = mjbiped.find_passive_gait(mjbiped.Compass(hip_mass=5.0), math.radians(3.6))
    assert printed["state_after_impact"] == gait.start.tolist()
    assert printed["state_before_impact"] == gait.end.tolist()
    assert (printed["period_s"], printed["step_length_m"]) == (gait.period, gait.step_length)
    assert (printed["speed_m_per_s"], printed["energy_J"]) == (gait.speed, gait.energy)
    assert [each["modulus"] for each in printed["multipliers"]] == pytest.approx(abs(gait.multipliers))
    assert printed["stable"] is gait.stable
    assert printed["files"] == {}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("--slope-deg", 0), "no passive gait on a slope of 0 degrees"),
        (("--slope-deg", "nan"), "'nan'; expected a number from -89.95"),
        (("--slope-deg", 40), "no passive gait"),
        (("--leg-mass", 0), "'--leg-mass'"),
        (("--plot", "gait.txt"), "must end in"),
    ],
)
def test_gait_refuses(words: tuple[object, ...], reason: str) -> None:
    assert_refused(run("gait", *words), reason)


def test_stability_tells_theorem_1(tmp_path: Path) -> None:
    record, plot = tmp_path / "walk.npz", tmp_path / "stability.png"
    words = ("--engine", "hybrid", "--steps", 4, "--initial-slope-estimate-deg", 3, "--quiet", "--out", record)
    assert run("walk", "level", *words).exit_code == 0
    result = run("stability", record, "--plot", plot)
    assert (result.exit_code, result.stderr) == (0, "")
    assert "condition 24 holds steps" in result.stdout
    assert result.stdout.endswith(f"wrote {plot}\n")
    assert plot.stat().st_size > 10_000
    printed = json.loads(run("stability", record, "--json").stdout)
    found = stability(mjbiped.Walk.load(record))
    assert printed["condition_24_smallest_for_any_constants"] == found.condition_floor.min() > 1.0
    assert (printed["condition_24_holds_steps"], printed["errors_26_holds_steps"], printed["steps"]) == (0, 3, 4)


def test_stability_refuses(record: Path, tmp_path: Path) -> None:
    assert_refused(run("stability", tmp_path / "none.npz"), "there is no such file")
    assert_refused(run("stability", record, "--plot", tmp_path / "walk.gif"), "must end in .png")
