"""What no command takes is refused before anything is computed: status 2, one line that names it, and no file."""

import os
import shlex
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from command_line import assert_refused, run
from time_limits import within

from mjbiped.utils.files import LONGEST

GREAT = "9" * 400

REFUSED = {
    # numbers and words outside their domains
    "walk random --seed -1": "'-1'; expected a whole number from 0",
    "walk --replanning-delay 1.01": "expected a number from 0.001 to 1 gait periods, or 'none'",
    "walk --controller passivity --gain 3": "expected NAME=VALUE",
    "walk --video-size 641x480": "even pixels",
    "walk --hide ghost,torques": "valid are torque, force",
    "walk --start 2 --stop 1": "--start 2 comes after --stop 1; swap them",
    "walk --sole 0.1,0.1,0.1": "'--sole': '0.1,0.1,0.1'; expected one distance from 0 to 1000 m, or two, behind",
    f"walk --disturb delay={GREAT}": "delay",
    # grounds
    "walk marsh": "unknown terrain 'marsh'",
    "walk mixed --seed 1": "--seed is for the terrains random, treads, waves, bumps, recorded",
    "walk random:seed=1 --seed 2": "contradicts",
    # controllers and their settings
    "walk level --controller spread.py:HipSpread": 'give initial="rest" (--initial rest)',
    "walk --controller limit-cycle --estimate-update": "controller limit-cycle 'estimate_update'",
    "walk --position-gain 3 --gain position_gain=3": "--position-gain is given, too; give one of them",
    # robots
    "bifurcation --robot compass3d": "a Compass3D moves in space: mjbiped return-map --robot compass3d shows",
    "lateral-basin": "a Compass does not roll",
    "reference --robot kneed3d": "find_reference(robot.planar)",
    "export robot.urdf --robot compass3d": "export its scene (.xml)",
    "export bumps scene.xml --robot compass3d": "a surface",
    "walk bumps": "--robot compass3d, kneed3d",
    "walk --robot knee": "unknown robot 'knee'",
    "walk --robot kneed --leg-mass 4": "--leg-mass is for --robot compass, footed, round, compass3d, abducting3d;",
    "walk --robot kneed --model-error leg_mass=1.2": "unknown parameter of the robot 'leg_mass'",
    "walk --robot bare.toml": "its kind is missing; without one it is a compass, which has no thigh_mass",
    "walk --model-error leg_mass=1 --model-error leg_mass=1": "a name is given twice",
    # engines
    "walk --engine hybrid --no-lands": "--no-lands is for --engine mujoco; hybrid has no such thing",
    # files to write
    "walk --out walk.mat": "'walk.mat' must end in .npz",
    "walk --out nowhere/walk.npz": "there is no folder 'nowhere'",
    f"walk --plot {'x' * 300}.png": "cannot be written",
    # records to read
    "render walk.npz --no-video": "--no-video needs a --plot",
    "view walk.npz --steps 3": "--steps is for walks that are made",
    "view": "`mjbiped render` draws a record without one",
    "export a b scene.xml": "2 sources are given, a and b; give one, then FILE",
    "export level robot.urdf": "robot.urdf is of a robot alone; leave 'level' out, or give a record",
    "export robot.urdf --seed 3": "--seed is for scenes (.xml); robot.urdf has no such thing",
    "export walk.npz scene.xml --robot kneed": "--robot is for a TERRAIN; the record walk.npz has no",
    "report steps.toml": "expected is the folder of its sweep, which is steps unless",
    "export level walk.csv": "walk.csv holds the samples of a walk: give the walk's record",
    "report walk.npz --out page.pdf": ".html",
    # gaits and maps
    "return-map --robot kneed --scuffing-reach 0.3": "scuffing is for straight legs",
    "bifurcation --slope-deg 3": "LOW..HIGH",
    "bifurcation --keep 700": "more than the 600 steps",
    "bifurcation --robot wheel": "no swing leg",
    "basin --controller spread.py:HipSpread": "HipSpread imitates no gait",
    "bifurcation --slopes 40000 --keep 600": "--keep times --slopes",
    # studies
    "sweep steps.toml --workers 1 --scheduler tcp://x": "--workers is for this machine",
    "reproduce --out bare.toml": "is a file",
    "figures bare.toml/folder": "cannot be made: Not a directory; give another folder",
    "compile spread.py:HipSpread": 'has no law(); the page "controller" of the documentation shows one',
    "compile adaptive --clear": "--clear deletes all machine code; give it alone",
}


@pytest.mark.usefixtures("no_walk")
@pytest.mark.parametrize("line", REFUSED, ids=lambda line: line[:60])
def test_refused(line: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    before = {path: path.stat().st_mtime_ns for path in folder.rglob("*")}
    assert_refused(run(*shlex.split(line)), REFUSED[line])
    assert {path: path.stat().st_mtime_ns for path in folder.rglob("*") if "__pycache__" not in path.parts} == before


@pytest.mark.parametrize(
    ("module", "words", "extra"),
    [
        ("pyarrow.parquet", ("walk", "--out", "walk.parquet"), "data"),
        ("plotly", ("report", "walk.npz"), "report"),
        ("distributed", ("sweep", "steps.toml", "--scheduler", "tcp://127.0.0.1:1"), "cluster"),
    ],
)
@pytest.mark.usefixtures("no_walk", "folder", "studies_in_threads")
def test_a_missing_extra(module: str, words: tuple[str, ...], extra: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    assert_refused(run(*words), f"which is not installed: pip install 'mjbiped[{extra}]'")


def sparse(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(8 << 30)


ODD: dict[str, tuple[Callable[[Path], object], str]] = {
    "sparse": (sparse, f"is longer than {LONGEST >> 20} MiB"),
    "pipe": (os.mkfifo, "is a device or a pipe"),
    "folder": (Path.mkdir, "is a folder"),
    "no text": (lambda path: path.write_bytes(b"kind = '\xff'"), ""),
    "brackets": (lambda path: path.write_text("a = " + "[" * 100_000), ""),
}


LINES = ["walk level --robot a.toml", "walk a.toml", "sweep a.toml", "walk --controller a.py:A"]


@pytest.mark.parametrize("line", LINES)
@pytest.mark.parametrize("kind", ODD)
def test_odd_files_are_refused_at_once(kind: str, line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    make, said = ODD[kind]
    make(tmp_path / f"a.{'py' if '.py' in line else 'toml'}")
    with within(20.0, kind):
        assert_refused(run(*line.split()), said)
