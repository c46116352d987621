"""The command `mjbiped reference`, and the option that lets controllers track what it finds."""

import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner

import mjbiped
from mjbiped.cli.main import main


def run(*words: str) -> tuple[int, str]:
    done = CliRunner().invoke(main, words)
    return done.exit_code, done.output


@pytest.mark.slow
def test_it_tells_the_gait(robot: mjbiped.Compass, tmp_path: Path) -> None:
    plot = tmp_path / "reference.png"
    status, text = run("reference", "--clearance", "0.05", "--json", "--plot", str(plot))
    assert status == 0
    printed = json.loads(text)
    gait = mjbiped.find_reference(robot, clearance=0.05)
    assert printed["cost_of_transport"] == gait.cost_of_transport
    assert (printed["period_s"], printed["half_angle_rad"]) == (gait.period, gait.end[0])
    assert printed["clearance_m"] == pytest.approx(0.05, abs=1e-6)  # the constraint is active
    assert plot.read_bytes().startswith(b"\x89PNG")


def test_its_table_has_units() -> None:
    status, text = run("reference", "--clearance", "0", "--speed", "0.4")
    assert status == 0
    assert re.search(r"speed +0\.4 +m/s", text)
    assert "N m" in text
    assert re.search(r"clearance phase +-", text)  # nothing is asked of the foot at any phase


@pytest.mark.slow  # a search that finds nothing takes longest
def test_what_cannot_be_is_told_in_one_line() -> None:
    status, text = run("reference", "--torque-limit", "0.5")
    assert status == 2
    assert text.startswith("Error: no reference was found")
    assert "raise the limit" in text


def test_walk_tracks_it(tmp_path: Path) -> None:
    record = tmp_path / "walk.npz"
    words = ("--reference", "clearance=0.05", "--gain", "replanning=additive", "--engine", "hybrid", "--steps", "3")
    status, text = run("walk", "level", *words, "--out", str(record), "--json")
    assert status == 0, text
    assert mjbiped.Walk.load(record).settings["controller"]["gait"]["goal"]["clearance"] == 0.05
    assert json.loads(text)["settings"]["controller"]["replanning"] == "additive"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--reference", "height=1"), "valid are speed, clearance, retraction, torque_limit, friction"),
        (("--reference", "clearance=-1"), "clearance = -1.0: must be"),
        (("--reference", "clearance=0.1", "--imitate-slope-deg", "3"), "give one of them"),
        (("--reference", "clearance=0.1", "--controller", "kinetic-energy"), "needs a passive gait"),
        (("--reference", "clearance=0.1", "--controller", "passive"), "of the controller passive 'reference'"),
        (("--gain", "replanning=sum"), "valid are paper, additive"),
    ],
)
def test_refused(words: tuple[str, ...], message: str) -> None:
    status, text = run("walk", "level", *words)
    assert status == 2
    assert message in " ".join(text.split())


@pytest.mark.slow
def test_with_knees(tmp_path: Path) -> None:
    plot = tmp_path / "knees.png"
    status, text = run("reference", "--robot", "kneed", "--clearance", "0", "--json", "--plot", str(plot))
    assert status == 0, text
    printed = json.loads(text)
    gait = mjbiped.find_reference(mjbiped.KneedBiped(), clearance=0.0)
    assert printed["cost_of_transport"] == gait.cost_of_transport
    assert printed["knee_strike_s"] == pytest.approx(0.88 * gait.period)
    assert printed["peak_knee_torque_Nm"] == gait.measures.peak_torque[2]
    assert len(printed["state_after_impact"]) == 6
    assert plot.read_bytes().startswith(b"\x89PNG")
    status, text = run("reference", "--robot", "halved-rods", "--leg-mass", "4")
    assert status == 2
    assert "--leg-mass is for --robot compass" in " ".join(text.split())
