"""Values of options: what is not in their domain is refused before a walk."""

from __future__ import annotations

from pathlib import Path

import pytest
from command_line import assert_refused, run

REFUSED: dict[str, tuple[tuple[object, ...], str]] = {
    "negative seed": (("random", "--seed", -1), "'-1'; expected a whole number from 0"),
    "zero leg mass": (("--leg-mass", 0), "'--leg-mass': '0'; expected a number from 1e-09 to 1e+06 kg"),
    "negative leg mass": (("--leg-mass", -1), "'--leg-mass': '-1'; expected a number"),
    "negative hip mass": (("--hip-mass", -1), "'--hip-mass': '-1'; expected a number from 0 to 1e+06 kg"),
    "no length": (("--lower-length", 0), "'--lower-length'"),
    "negative inertia": (("--leg-inertia", -1), "'--leg-inertia'"),
    "no gravity": (("--gravity", "nan"), "'--gravity'"),
    "zeta of zero": (("--replanning-delay", 0), "expected a number from 0.001 to 1 gait periods"),
    "zeta above one": (("--replanning-delay", 1.01), "expected a number from 0.001 to 1 gait periods"),
    "negative zeta": (("--replanning-delay", -0.5), "expected a number from 0.001 to 1 gait periods"),
    "zeta not a number": (("--replanning-delay", "nan"), "expected a number from 0.001 to 1"),
    "zeta in words": (("--replanning-delay", "never"), "gait periods, or 'none'"),
    "position gain": (("--position-gain", 0), "'--position-gain': '0'; expected a number from 1e-06"),
    "velocity gain": (("--velocity-gain", -12), "'--velocity-gain': '-12'; expected"),
    "adaptation gain": (("--adaptation-gain", "inf"), "'--adaptation-gain': 'inf'; expected"),
    "slope estimate": (("--initial-slope-estimate-deg", 90), "'--initial-slope-estimate-deg'"),
    "gain without name": (("--controller", "passivity", "--gain", 3), "expected NAME=VALUE"),
    "unknown source": (("--controller", "passivity", "--slope-source", "map"), "'--slope-source'"),
    "slope given": (
        ("--controller", "passivity", "--initial-slope-estimate-deg", 90),
        "expected a number from -89.95 to 89.95 degrees",
    ),
    "no steps": (("--steps", 0), "'--steps'"),
    "half a step": (("--steps", 1.5), "'--steps'"),
    "no way": (("--distance", 0), "'--distance': '0'; expected a number from 1e-06"),
    "way not a number": (("--distance", "nan"), "'--distance': 'nan'; expected a number"),
    "unknown engine": (("--engine", "bullet"), "'--engine'"),
    "unknown controller": (("--controller", "pid"), "unknown controller 'pid': valid are adaptive"),
    "unknown state": (("--initial", "run"), "'gait', 'rest' or four numbers"),
    "three numbers": (("--initial", "1,2,3"), "an initial state is four finite numbers"),
    "state not a number": (("--initial", "0,0,nan,0"), "'gait', 'rest' or four numbers"),
    "no timestep": (("--timestep", 0), "expected a number from 1e-06 to 0.004 s"),
    "long timestep": (("--timestep", 0.1), "expected a number from 1e-06 to 0.004 s"),
    "odd video": (("--video-size", "641x480"), "even pixels"),
    "small video": (("--video-size", "2x2"), "even pixels"),
    "video size in words": (("--video-size", "large"), "even pixels"),
    "slow motion": (("--slow-motion", 0), "a number from 0.01 to 100"),
    "slow motion not a number": (("--slow-motion", "nan"), "a number from 0.01 to 100"),
    "no frames": (("--fps", 0), "'--fps'"),
    "unknown camera": (("--camera", "moon"), "'--camera'"),
    "unknown option": (("--gains", 3), "--gains"),
    "too many words": (("level", "mixed"), "unexpected extra argument"),
    "record suffix": (("--out", "walk.mat"), "'walk.mat' must end in .npz"),
    "plot suffix": (("--plot", "walk.bmp"), "must end in .png or .pdf or .svg"),
    "video suffix": (("--video", "walk.avi"), "must end in .mp4 or .gif"),
    "unknown element": (("--hide", "ghost,torques"), "valid are torque, force"),
    "unknown flag": (("--flag", "contactpoints"), "did you mean 'contactpoint'?"),
    "begin of the video": (("--start", -1), "'--start'"),
    "video backwards": (("--start", 2, "--stop", 1), "--start 2 comes after --stop 1; swap them"),
    "no folder": (("--out", "nowhere/walk.npz"), "there is no folder 'nowhere'"),
    "long name": (("--plot", "x" * 300 + ".png"), "cannot be written"),
}


@pytest.mark.usefixtures("no_walk")
@pytest.mark.parametrize(("words", "reason"), REFUSED.values(), ids=REFUSED.keys())
def test_walk_refuses_values_outside_their_domains(
    words: tuple[object, ...], reason: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert_refused(run("walk", *words), reason)
    assert not list(tmp_path.iterdir())


@pytest.mark.usefixtures("no_walk")
@pytest.mark.parametrize(("option", "name"), [("--out", "w.npz"), ("--plot", "w.png"), ("--video", "w.mp4")])
def test_walk_refuses_outputs_that_cannot_be_written(option: str, name: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    (tmp_path / name).mkdir()
    assert_refused(run("walk", option, tmp_path / "file" / name), "there is no folder")
    assert_refused(run("walk", option, tmp_path / name), "Is a directory")


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="needs a folder that takes no file, from root neither")
@pytest.mark.usefixtures("no_walk")
def test_walk_refuses_a_folder_that_takes_no_files() -> None:
    assert_refused(run("walk", "--out", "/proc/self/walk.npz"), "cannot be written")
