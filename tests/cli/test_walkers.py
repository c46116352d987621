"""Options reach controller, robot, terrain and engine; what does not fit together is refused before a walk."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from command_line import assert_refused, complaints, run

import mjbiped
from controllers import Controller, PassivityController
from mjbiped.records.record import Walk


def test_plain_steps_reach_the_engine(tmp_path: Path) -> None:
    out = tmp_path / "walk.npz"
    words = ("walk", "level", "--steps", 1, "--timestep", 1e-4, "--no-lands", "--out", out, "--quiet")
    assert run(*words).exit_code == 0
    assert Walk.load(out).settings["lands"] is False


@pytest.mark.slow
def test_a_motor_at_the_stance_knee_reaches_the_engine(tmp_path: Path) -> None:
    out = tmp_path / "walk.npz"
    words = ("walk", "incline:slope_deg=2.5", "--robot", "kneed", "--controller", "passive", "--stance-knee", "motor")
    assert run(*words, "--steps", 1, "--out", out, "--quiet").exit_code == 0
    assert Walk.load(out).settings["stance_knee"] == "motor"
    assert Walk.load(out).summary()["peak_stance_knee_torque_Nm"] > 0.0


def test_a_motor_at_the_stance_knee_needs_one() -> None:
    straight = run("walk", "level", "--stance-knee", "motor", "--steps", 1)
    assert straight.exit_code == 2
    assert 'stance_knee = "motor" needs a robot with knees' in complaints(straight)


@pytest.mark.parametrize(
    "option", [("--no-lands",), ("--timestep", 1e-4), ("--control-period", 1e-3), ("--stance-knee", "motor")]
)
def test_the_hybrid_engine_refuses_mujocos_options(option: tuple[object, ...]) -> None:
    result = run("walk", "level", "--engine", "hybrid", *option)
    assert result.exit_code == 2
    assert f"{option[0]} is for --engine mujoco; hybrid has no such thing." in complaints(result)


def test_options_reach_controller_robot_and_engine(tmp_path: Path) -> None:
    out = tmp_path / "walk.npz"
    gains = ("--position-gain", 6, "--velocity-gain", 11, "--adaptation-gain", 0.2, "--initial-slope-estimate-deg", 0.5)
    switches = ("--replanning-delay", "none", "--no-estimate-update", "--imitate-slope-deg", 1.5, "--hip-mass", 3)
    times = ("--timestep", 5e-4, "--control-period", 1e-3, "--distance", 0.2, "--initial", "-0.15,0.15,0.9,0.7")
    result = run("walk", "random:slope_deg=-1..1", "--seed", 7, *gains, *switches, *times, "--out", out, "--quiet")
    assert (result.exit_code, result.output) == (0, "")
    settings = Walk.load(out).settings
    law = settings["controller"]
    assert (law["position_gain"], law["velocity_gain"], law["adaptation_gain"]) == (6.0, 11.0, 0.2)
    assert (law["replanning_delay"], law["estimate_update"]) == (None, False)
    assert law["initial_slope_estimate"] == pytest.approx(math.radians(0.5))
    assert law["gait"]["slope"] == pytest.approx(math.radians(1.5))
    assert law["robot"] == settings["robot"] == mjbiped.Compass(hip_mass=3.0).to_dict()
    assert (settings["timestep"], settings["control_period"]) == (5e-4, 1e-3)
    assert (settings["steps"], settings["distance"]) == (None, 0.2)
    assert settings["initial"] == [-0.15, 0.15, 0.9, 0.7]
    assert Walk.load(out).terrain == mjbiped.Terrain.random(seed=7, slope_deg=(-1.0, 1.0))


@pytest.mark.parametrize(
    ("name", "kind", "gains"),
    [
        ("passivity", "PassivityController", {"gain": 7.0}),
        ("energy-constraint", "EnergyConstraintController", {"ratio": -2.0, "gain": 9.0}),
        ("kinetic-energy", "KineticEnergyController", {"slowest": 0.2}),
        ("limit-cycle", "LimitCycleController", {"rate_gain": 12.0, "position_gain": 36.0}),
    ],
)
def test_options_reach_a_comparison_controller(
    name: str, kind: str, gains: dict[str, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    given = [word for key, value in gains.items() for word in ("--gain", f"{key}={value}")]
    slopes = ("--imitate-slope-deg", 1.5, "--initial-slope-estimate-deg", 0.5, "--slope-source", "none")
    law = controller_of(monkeypatch, "walk", "incline:slope_deg=0.5", "--controller", name, *given, *slopes)
    assert (law["name"], law["slope_source"]) == (kind, "none")
    assert law["initial_slope_estimate"] == pytest.approx(math.radians(0.5))
    assert law["gait"]["slope"] == pytest.approx(math.radians(1.5))
    assert {key: law[key] for key in gains} == gains


def controller_of(monkeypatch: pytest.MonkeyPatch, *words: object) -> dict[str, Any]:
    """What the controller says of itself with which a command would walk."""
    taken: list[Controller] = []

    def walk(controller: Controller, *_: object, **__: object) -> None:
        taken.append(controller)
        raise mjbiped.InputError("enough")

    monkeypatch.setattr(mjbiped, "walk", walk)
    assert run(*words).stderr == "Error: enough\n"
    described: dict[str, Any] = taken[0].describe()
    return described


def test_a_comparison_controller_keeps_its_defaults(monkeypatch: pytest.MonkeyPatch) -> None:
    gait = mjbiped.find_passive_gait(mjbiped.Compass(), math.radians(2))
    law = controller_of(monkeypatch, "walk", "level", "--controller", "passivity")
    assert law == PassivityController(mjbiped.Compass(), gait).describe()


@pytest.mark.parametrize("text", ["random", "random:seed=4", "random:roughness=0.001"])
def test_seed_is_that_of_the_random_terrain(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    walked: list[mjbiped.Terrain] = []

    def walk(_: object, terrain: mjbiped.Terrain, **__: object) -> None:
        walked.append(terrain)
        raise mjbiped.InputError("enough")

    monkeypatch.setattr(mjbiped, "walk", walk)
    assert run("walk", text, "--seed", 4).stderr == "Error: enough\n"
    roughness = 0.001 if "roughness" in text else 0.0
    assert walked == [mjbiped.Terrain.random(seed=4, roughness=roughness)]


REFUSED: dict[str, tuple[tuple[object, ...], str]] = {
    "unknown preset": (("marsh",), "unknown terrain 'marsh'"),
    "unknown parameter": (("stairs:depth=1",), "depth"),
    "unreadable parameter": (("stairs:rise",), "expected key=value"),
    "missing file": (("trail.csv",), "there is no such file"),
    "unknown file": (("trail.xlsx",), "unknown suffix"),
    "too steep": (("incline:slope_deg=50",), "steeper than the robot can stand on"),
    "too steep in the end": (("slopes:change_deg=9",), "steeper than the robot can stand on"),
    "seed of no random terrain": (("mixed", "--seed", 1), "--seed is for the terrains random, treads, waves, recorded"),
    "two seeds": (("random:seed=1", "--seed", 2), "contradicts"),
    "no gait uphill": (("--imitate-slope-deg", -1), "no passive gait on a slope of -1 degrees"),
    "no gait so steep": (("--imitate-slope-deg", 30), "no passive gait on a slope of 30 degrees"),
    "no passive gait on the level": (("level", "--controller", "passive"), "no passive gait on a slope of 0 degrees"),
    "gain without controller": (("--controller", "passive", "--position-gain", 5), "unknown setting of"),
    "switch without controller": (
        ("--controller", "passive", "--estimate-update"),
        "unknown setting of",
    ),
    "gains of another": (("--controller", "passivity", "--position-gain", 5), "unknown setting of"),
    "switch of another": (
        ("--controller", "limit-cycle", "--estimate-update"),
        "controller limit-cycle 'estimate_update'",
    ),
    "gain of the adaptive": (
        ("--gain", "gain=5"),
        "controller adaptive 'gain': valid are imitate_slope_deg=2.0",
    ),
    "source of the passive": (
        ("--controller", "passive", "--slope-source", "local"),
        "unknown setting of",
    ),
    "source of the library": (
        ("--controller", "library", "--slope-source", "local"),
        "unknown setting of",
    ),
    "unknown gain": (
        ("--controller", "energy-constraint", "--gain", "mu=2"),
        "gain=5.0, ratio=-2.3, singular_band=0.1",
    ),
    "no gain's field": (
        ("--controller", "passivity", "--gain", "initial_slope_estimate=2"),
        "controller passivity 'initial_slope_estimate'",
    ),
    "gain not a number": (
        ("--controller", "passivity", "--gain", "gain=much"),
        "--gain gain: gain = 'much': must be a finite number",
    ),
    "gain of zero": (("--controller", "passivity", "--gain", "gain=0"), "gain = 0.0: must be from 1e-06"),
    "control period": (("--control-period", 1.5e-4), "multiple of the timestep"),
}


@pytest.mark.usefixtures("no_walk")
@pytest.mark.parametrize(("words", "reason"), REFUSED.values(), ids=REFUSED.keys())
def test_walk_refuses_what_does_not_fit_together(
    words: tuple[object, ...], reason: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert_refused(run("walk", *words), reason)
    assert not list(tmp_path.iterdir())


TERRAIN_FILES: dict[str, tuple[str, str, str]] = {
    "empty": ("a.csv", "", "the file is empty"),
    "blank": ("a.toml", " \n", "the file is empty"),
    "not a number": ("a.csv", "0,0\n1,nan\n2,0\n", "line 2: z = nan: must be a finite number"),
    "unsorted": ("a.csv", "0,0\n2,0\n1,0\n", "sort the rows by x"),
    "too short": ("a.csv", "0,0\n", "expected at least two rows"),
    "too steep": ("a.csv", "0,0\n1,2\n", "steeper than the robot can stand on"),
    "elsewhere": ("a.csv", "5,0\n9,0\n", "the robot starts at x = 0"),
    "no segments": ("a.yaml", "segments: []\n", "there are no segments"),
    "bad segment": ("a.toml", "segments = [[-1, 0]]\n", "segment 1: length"),
}


@pytest.mark.usefixtures("no_walk")
@pytest.mark.parametrize(("name", "text", "reason"), TERRAIN_FILES.values(), ids=TERRAIN_FILES.keys())
def test_walk_refuses_terrain_files(name: str, text: str, reason: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text(text)
    result = run("walk", path)
    assert_refused(result, reason)
    assert str(path) in result.stderr
