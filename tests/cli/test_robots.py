"""Robots on the command line: by name, by file, by single parameters; and what does not fit, told in one line."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import pytest
from click.testing import CliRunner
from command_line import run

import mjbiped
from controllers import AdaptiveController, KneedController
from mjbiped.cli.commands import Command, Given
from mjbiped.cli.options import parameter_options
from mjbiped.control.registry import controller_from, make_controller
from mjbiped.errors import InputError
from mjbiped.exchange.mjcf import export_scene
from mjbiped.robots.robot import Robot
from mjbiped.utils import domains

KNEED = mjbiped.KneedBiped()


@pytest.fixture
def walks(monkeypatch: pytest.MonkeyPatch) -> list[tuple[Any, Robot]]:
    """Controller and robot of each walk that a command would make; none is made."""
    asked: list[tuple[Any, Robot]] = []

    def walk(controller: Any, terrain: Any, *, robot: Robot, **_: Any) -> None:
        asked.append((controller, robot))
        raise InputError("not walked")

    monkeypatch.setattr("mjbiped.walk", walk)
    return asked


def asked(walks: list[tuple[Any, Robot]], *words: object) -> Robot:
    result = run("walk", "level", "--engine", "hybrid", "--controller", "passive", *words)
    assert "not walked" in result.output
    return walks[-1][1]


def test_robots_by_name_and_parameter(walks: list[tuple[Any, Robot]]) -> None:
    assert asked(walks) == mjbiped.Compass()
    assert asked(walks, "--robot", "kneed") == KNEED
    assert asked(walks, "--robot", "halved-rods") == mjbiped.KneedBiped.halved_rods()
    heavy = asked(walks, "--robot", "kneed", "--hip-mass", 7, "--thigh-mass", 4)
    assert heavy == mjbiped.KneedBiped(hip_mass=7.0, thigh_mass=4.0)
    rods = asked(walks, "--robot", "halved-rods", "--shank-mass", 2)
    # a rod's inertia follows its mass
    assert rods == replace(mjbiped.KneedBiped.halved_rods(), shank_mass=2.0, shank_inertia=2.0 * 0.25 / 12)
    assert asked(walks, "--leg-mass", 4) == mjbiped.Compass(leg_mass=4.0)
    assert asked(walks, "--sole", 0.12) == mjbiped.Compass(sole=(0.12, 0.12))
    assert asked(walks, "--robot", "kneed", "--sole", "0.05,0.15") == mjbiped.KneedBiped(sole=(0.05, 0.15))


def test_robots_by_file(walks: list[tuple[Any, Robot]], tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('kind = "kneed"\nthigh_mass = 3.5\nshank_centre = 0.1\n', encoding="utf-8")
    mine = mjbiped.KneedBiped(thigh_mass=3.5, shank_centre=0.1)
    assert asked(walks, "--robot", path) == mine
    assert asked(walks, "--robot", path, "--gravity", 3.7) == replace(mine, gravity=3.7)
    path.write_text("leg_mass = 3.5\n", encoding="utf-8")
    assert asked(walks, "--robot", path) == mjbiped.Compass(leg_mass=3.5)


def test_robots_by_mjcf(walks: list[tuple[Any, Robot]], tmp_path: Path) -> None:
    path = tmp_path / "mine.xml"
    export_scene(mjbiped.Compass(hip_mass=2.0), mjbiped.Terrain.level(), path)
    assert asked(walks, "--robot", path) == mjbiped.Compass(hip_mass=2.0)
    assert asked(walks, "--robot", path, "--sole", 0.1) == mjbiped.Compass(hip_mass=2.0, sole=(0.1, 0.1))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ("--robot", "knee"),
            "unknown robot 'knee'",
        ),
        (("--robot", "none.toml"), "there is no such file"),
        (("--robot", "none.xml"), "--robot 'none.xml': there is no such file"),
        (
            ("--robot", "kneed", "--leg-mass", 4),
            "--leg-mass is for --robot compass, footed, round; kneed has no such thing",
        ),
        (("--thigh-mass", 4), "--thigh-mass is for --robot kneed, round-kneed, halved-rods; compass has no such thing"),
        (
            ("--robot", "wheel", "--hip-mass", 4),
            "--hip-mass is for --robot compass, footed, kneed, round, round-kneed, halved-rods; wheel has no such",
        ),
        (("--thigh-mass", -1), "Invalid value for '--thigh-mass': '-1'; expected a number from 1e-09 to 1e+06 kg."),
        (
            ("--sole", "0.1,0.1,0.1"),
            "'--sole': '0.1,0.1,0.1'; expected one distance from 0 to 1000 m, or two, behind",
        ),
        (
            ("--robot", "wheel", "--sole", 0.1),
            "--sole is for --robot compass, footed, kneed, halved-rods; wheel has no such",
        ),
        (
            ("--robot", "bare.toml"),
            "its kind is missing; without one it is a compass, which has no thigh_mass",
        ),
        (("--model-error", "sole=2"), "--model-error: unknown parameter of the robot 'sole'"),
        (("--robot", "wheel", "--spokes", 4), "'--spokes': '4'; expected a whole number from 5 to 100."),
        (("--robot", "kneed", "--thigh-centre", 0.6), "thigh_centre = 0.6: must lie on the link"),
        (("--robot", "odd.toml"), "--robot 'odd.toml': unknown parameter of the robot kneed 'thigh'"),
        (("--robot", "kneed", "--model-error", "leg_mass=1.2"), "unknown parameter of the robot 'leg_mass'"),
    ],
)
def test_what_does_not_fit_is_refused(
    words: tuple[object, ...], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("bare.toml").write_text("thigh_mass = 2.5\n", encoding="utf-8")
    Path("odd.toml").write_text('kind = "kneed"\nthigh = 3.5\n', encoding="utf-8")
    result = run("walk", "level", "--engine", "hybrid", "--controller", "passive", *words)
    assert result.exit_code == 2
    assert said in " ".join(result.output.split())


@dataclass(frozen=True)
class Sprung(mjbiped.RimlessWheel):
    """A wheel on springs.

    Attributes:
        stretch: Length that the springs add, over all
            of the spokes, m. None of it is lost.
        gravity: Not asked here.
    """

    stretch: Annotated[float, domains.LENGTH] = 0.25


def test_a_further_robot_has_its_options() -> None:
    def show(*, robot: Annotated[Given, [*parameter_options({"sprung": Sprung})]]) -> None:
        """Show."""
        print(robot["stretch"])

    command = Command("show", show)
    assert "Robot:" in (text := CliRunner().invoke(command, ["--help"]).output)
    assert "--stretch X  Length that the springs add, over all of the spokes, m." in text
    assert "[default: 0.25]" in text
    assert "None of it" not in text
    assert CliRunner().invoke(command, ["--stretch", "2"]).output == "2.0\n"
    assert "expected a number from 1e-09 to 1000 m" in CliRunner().invoke(command, ["--stretch", "-2"]).output


def test_the_adaptive_law_has_a_class_for_knees() -> None:
    slope = {"imitate_slope_deg": 2.5}
    law = make_controller("adaptive", KNEED, {**slope, "knee_bump": 0.4, "position_gain": 6.0})
    assert isinstance(law, KneedController)
    assert (law.knee_bump, law.position_gain, law.robot) == (0.4, 6.0, KNEED)
    assert controller_from(law.describe()) == law
    assert isinstance(make_controller("adaptive", mjbiped.Compass(), slope), AdaptiveController)
    with pytest.raises(InputError, match="knee_bump"):
        make_controller("adaptive", mjbiped.Compass(), {"knee_bump": 0.4})


@pytest.mark.slow
def test_the_issues_command_walks(tmp_path: Path) -> None:
    plot = tmp_path / "knees.png"
    result = run("walk", "stairs:rise=0.04", "--robot", "kneed", "--engine", "hybrid", "--steps", 20, "--plot", plot)
    assert result.exit_code == 0, result.output
    assert "finished" in result.output
    assert plot.stat().st_size > 1e5
