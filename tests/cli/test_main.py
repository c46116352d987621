"""The command line: what it prints and writes, what it refuses before a walk, and its exit status."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
import mujoco
import pytest
from click.testing import Result
from command_line import run
from PIL import Image

import mjbiped
from controllers import AdaptiveController, Controller, PassivityController
from mjbiped.analysis.stability import stability
from mjbiped.cli import main as cli
from mjbiped.cli import options as cli_options
from mjbiped.engines.mujoco import run as mujoco_run
from mjbiped.engines.mujoco import scene
from mjbiped.errors import RenderError
from mjbiped.plotting import comparison as plot_comparison
from mjbiped.plotting import style as plot_style
from mjbiped.plotting import walk as plots
from mjbiped.plotting import width as plot_width
from mjbiped.records import measures, recorder
from mjbiped.records.record import Walk
from mjbiped.rendering import gl, video
from mjbiped.terrain.presets import PRESETS

ROOT = Path(__file__).parents[2]


def complaints(result: Result | subprocess.CompletedProcess[str]) -> str:
    """What is on stderr, but for the line of a first walk that waits for the compiler."""
    return "".join(line for line in result.stderr.splitlines(keepends=True) if not line.startswith("compiling "))


def run_process(*words: object, cwd: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a command line in a process of its own, elsewhere than in the checkout."""
    path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    return subprocess.run(
        [sys.executable, "-m", "mjbiped", *map(str, words)],
        cwd=cwd,
        env={**os.environ, "PYTHONPATH": path, **environment},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The record of a short walk."""
    path = tmp_path_factory.mktemp("record") / "walk.npz"
    assert run("walk", "level", "--steps", 1, "--out", path, "--quiet").exit_code == 0
    return path


@pytest.fixture
def no_walk(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing may be simulated."""

    def simulate(*_: object, **__: object) -> None:
        raise AssertionError("a walk was computed")

    monkeypatch.setattr(mujoco_run, "simulate", simulate)


class Drawings:
    """Stands for the plots and videos: remembers how they were called, and writes a file."""

    def __init__(self) -> None:
        self.calls: list[tuple[str, dict[str, Any]]] = []

    def plot_walk(self, walk: Walk, path: Path) -> None:
        self.calls.append(("plot_walk", {"steps": walk.steps}))
        path.write_text("plot")

    def plot_comparison(self, comparison: mjbiped.Comparison, path: Path) -> None:
        self.calls.append(("plot_comparison", {"steps": comparison.mujoco.steps}))
        path.write_text("plot")

    def plot_gait(self, gait: mjbiped.Gait, path: Path) -> None:
        self.calls.append(("plot_gait", {"slope": gait.slope}))
        path.write_text("plot")

    def render_video(self, walk: Walk, path: Path, **settings: Any) -> None:
        self.calls.append(("render_video", {"steps": walk.steps, **settings}))
        path.write_text("video")


@pytest.fixture
def drawings(monkeypatch: pytest.MonkeyPatch) -> Drawings:
    """Nothing is drawn in earnest."""
    fake = Drawings()
    monkeypatch.setattr(plots, "plot_walk", fake.plot_walk)
    monkeypatch.setattr("mjbiped.plotting.gait.plot_gait", fake.plot_gait)
    monkeypatch.setattr(plot_comparison, "plot_comparison", fake.plot_comparison)
    monkeypatch.setattr(video, "render_video", fake.render_video)
    monkeypatch.setattr(gl, "gl_available", lambda: "egl")
    return fake


# ---- help ------------------------------------------------------------------------------------------------------------


COMMANDS = (
    "walk",
    "compare",
    "gait",
    "reference",
    "bifurcation",
    "basin",
    "stability",
    "render",
    "export",
    "view",
    "report",
    "sweep",
    "robustness",
    "reproduce",
    "compile",
)


def test_help_names_the_commands_in_order() -> None:
    result = run("--help")
    assert result.exit_code == 0
    listed = result.stdout[result.stdout.index("Commands:") :]
    assert re.findall(r"^  (\w+)", listed, re.MULTILINE) == list(COMMANDS)


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_a_command_explains_every_option(command: str) -> None:
    text = run(command, "--help").stdout
    assert "Examples:" in text
    sentence = " ".join(str(cli.main.commands[command].help).partition("\n\n")[0].split())
    assert " ".join(run("--help").stdout.split()).count(f"{command} {sentence}") == 1  # said there without an import
    for parameter in cli.main.commands[command].params:
        if isinstance(parameter, click.Option):
            assert parameter.help, parameter.name
            assert parameter.opts[0] in text


def test_help_groups_options_and_shows_defaults() -> None:
    text = run("walk", "--help").stdout
    sections = re.findall(r"^(\w[\w ,-]*):$", text, re.MULTILINE)
    assert sections[-12:] == [
        "Walk",
        "MuJoCo",
        "Adaptive controller",
        "Comparison controllers",
        "Robot",
        "Robot compass",
        "Robot kneed, halved-rods",
        "Robot wheel",
        "Disturbances",
        "Results",
        "Video",
        "Options",
    ]
    assert text.count("[default:") > 15
    assert "[default: 0.8]" in text


def test_version() -> None:
    assert run("--version").stdout == f"mjbiped, version {mjbiped.__version__}\n"


def test_options_agree_with_what_they_set() -> None:
    options = {parameter.name: parameter for parameter in cli.main.commands["walk"].params}
    sections = {name: getattr(parameter, "section", "") for name, parameter in options.items()}
    named = ("", " compass", " kneed, halved-rods", " wheel")
    shared, legs, knees, wheel = ({name for name in sections if sections[name] == f"Robot{each}"} for each in named)
    assert shared == {"robot", "hip_mass", "gravity", "sole"}
    assert legs == {field.name for field in dataclasses.fields(mjbiped.Compass)} - shared
    assert knees == {field.name for field in dataclasses.fields(mjbiped.KneedBiped)} - shared
    assert wheel == {field.name for field in dataclasses.fields(mjbiped.RimlessWheel)} - shared
    for suffix in plot_style.SUFFIXES:
        assert options["plot"].type(f"walk{suffix}", options["plot"], None) == Path(f"walk{suffix}")
    model = mujoco.MjModel.from_xml_path(str(scene.models_folder() / "scene.xml"))
    assert {model.camera(index).name for index in range(model.ncam)} == set(cli_options.CAMERAS)


# ---- walk ------------------------------------------------------------------------------------------------------------


def test_walk_in_a_process_prints_json_alone_and_writes_what_it_lists(tmp_path: Path) -> None:
    # quiet: a first walk says on stderr that something is being compiled
    words = ("walk", "stairs:rise=-0.02", "--steps", 2, "--quiet", "--json", "--out", "a.npz", "--plot", "a.svg")
    result = run_process(*words, cwd=tmp_path)
    assert (result.returncode, result.stderr) == (0, "")
    printed = json.loads(result.stdout)
    assert printed.pop("files") == {"record": "a.npz", "plot": "a.svg"}
    walk = Walk.load(tmp_path / "a.npz")
    assert printed.pop("settings") == walk.settings
    assert printed == json.loads(json.dumps(measures.summary(walk)))
    assert (printed["outcome"], printed["steps"]) == ("finished", 2)
    assert walk.terrain == mjbiped.Terrain.stairs(rise=-0.02)
    assert "<svg" in (tmp_path / "a.svg").read_text(encoding="utf-8")


def test_walk_prints_a_table_of_all_measures_and_the_files(tmp_path: Path, drawings: Drawings) -> None:
    out, plot, film = tmp_path / "[b].npz", tmp_path / "a.png", tmp_path / "a.mp4"
    words = ("walk", "--steps", 1, "--out", out, "--plot", plot, "--video", film)
    result = run(
        *words,
        "--slow-motion",
        2,
        "--fps",
        25,
        "--camera",
        "side",
        "--video-size",
        "320x200",
        "--hide",
        "shadows,ghost",
    )
    assert (result.exit_code, complaints(result)) == (0, "")
    summary = measures.summary(Walk.load(out))
    for shown in (
        "finished",
        "mixed",
        f"{summary['distance_m']:.3f}",
        f"{summary['cost_of_transport']:.4f}",
        f"{summary['peak_ankle_torque_Nm']:.2f}",
        f"{summary['largest_slip_m'] * 1e3:.4f}",
        "N m",
        "mm",
        "deg",
    ):
        assert shown in result.stdout
    assert result.stdout.endswith(f"wrote {out}\nwrote {plot}\nwrote {film}\n")
    size = {"width": 320, "height": 200, "fps": 25, "camera": "side", "slow_motion": 2.0, "start": None, "stop": None}
    assert drawings.calls == [
        ("plot_walk", {"steps": 1}),
        ("render_video", {"steps": 1, **size, "hide": ("shadows,ghost",), "flags": (), "progress": True}),
    ]


@pytest.mark.slow
def test_table_fits_a_narrow_terminal_of_plain_ascii(tmp_path: Path) -> None:
    words = ("walk", "random", "--steps", 1)
    result = run_process(*words, cwd=tmp_path, COLUMNS="50", PYTHONIOENCODING="ascii")
    assert (result.returncode, complaints(result)) == (0, "")
    assert max(map(len, result.stdout.splitlines())) <= 50
    assert "cost of transport" in result.stdout


def test_no_line_of_a_piped_table_is_broken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)
    lines = run("walk", "random:seed=3", "--engine", "hybrid", "--steps", 1).output.splitlines()
    shown = {line.strip().split("  ")[0] for line in lines if line.strip()}
    assert {label for label, *_ in measures.MEASURES if "estimate error" in label} <= shown
    assert "foot that holds it 99 % of the time, length" in shown


def test_quiet_walk_says_nothing(record: Path, tmp_path: Path) -> None:
    out = tmp_path / "walk.npz"
    out.write_text("an older file is replaced")
    assert run("walk", "level", "--steps", 1, "--out", out, "--quiet").output == ""
    assert Walk.load(out) == Walk.load(record)


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


def test_a_fall_is_a_result(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo may write its log
    words = ("walk", "level", "--controller", "passive", "--initial", "0.1,0.1,1,1", "--json", "--timestep", 5e-4)
    result = run(*words)
    assert result.exit_code == 0
    printed = json.loads(result.stdout)
    assert (printed["outcome"], printed["steps"], printed["cost_of_transport"]) == ("fell", 0, None)
    assert "fell" in run(*words[:-3], "--timestep", 5e-4).stdout


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_ctrl_c_and_sigterm_keep_the_walk_so_far(
    number: signal.Signals, status: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, drawings: Drawings
) -> None:
    add = recorder.Recorder.add
    count = iter(range(1000))

    def interrupted(*arguments: Any) -> None:
        add(*arguments)
        if next(count) == 3:
            signal.raise_signal(number)

    monkeypatch.setattr(recorder.Recorder, "add", interrupted)
    out, plot = tmp_path / "walk.npz", tmp_path / "walk.png"
    result = run("walk", "--timestep", 2e-4, "--out", out, "--plot", plot, "--json")
    assert result.exit_code == status
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL
    assert result.stderr == f"Error: the walk was interrupted after 0 steps; what was walked is in {out}\n"
    walk = Walk.load(out)
    assert walk.outcome == "interrupted"
    assert len(walk.samples["time"]) > 60  # of some 500 physics steps each time
    assert json.loads(result.stdout)["files"] == {"record": str(out)}
    assert not drawings.calls


def test_sigterm_ends_the_process_cleanly(tmp_path: Path) -> None:
    """In the midst of a file, with the exit status that shells have; a second one ends it at once."""
    program = tmp_path / "program.py"
    program.write_text(
        "import mjbiped, signal, sys, time\n"
        "from pathlib import Path\n"
        "from mjbiped.cli import main as cli\n"
        "from mjbiped.utils.files import written_whole\n"
        "def walk(*_, **__):\n"
        "    with written_whole(Path(sys.argv[1])) as unfinished:\n"
        "        unfinished.write_text('half')\n"
        "        signal.raise_signal(signal.SIGTERM)\n"
        "        time.sleep(600.0)\n"
        "mjbiped.walk = walk\n"
        "cli.main(['walk', 'level', '--controller', 'passive'])\n"
    )
    root = str(Path(__file__).parents[2])
    path = os.pathsep.join(filter(None, (root, os.environ.get("PYTHONPATH"))))
    done = subprocess.run(
        [sys.executable, str(program), str(tmp_path / "walk.npz")],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (143, "", "Error: interrupted\n")
    assert [file.name for file in tmp_path.iterdir()] == [program.name]


def test_a_controller_that_fails_keeps_the_walk_so_far(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def on_touchdown(*_: object) -> None:
        raise ZeroDivisionError("no way on")

    monkeypatch.setattr(AdaptiveController, "on_touchdown", on_touchdown)
    monkeypatch.setattr(AdaptiveController, "law", lambda _: None)  # which would be compiled in its place
    out = tmp_path / "walk.npz"
    result = run("walk", "level", "--out", out, "--timestep", 5e-4)
    assert result.exit_code == 1
    assert re.fullmatch(
        rf"Error: AdaptiveController failed .*no way on .*test_main.py.*; .* {re.escape(str(out))}\n", result.stderr
    )
    assert "interrupted" in result.stdout
    assert Walk.load(out).outcome == "interrupted"


# ---- drawings that fail ----------------------------------------------------------------------------------------------


def test_a_plot_is_as_wide_as_asked_for(record: Path, tmp_path: Path) -> None:
    plot = tmp_path / "narrow.png"
    assert run("render", record, "--no-video", "--plot", plot, "--plot-width", "single").exit_code == 0
    with Image.open(plot) as picture:
        assert picture.width == 1050  # 3.5 in of 300 dots
    assert plot_width.width() is plot_width.WIDTHS["page"]
    assert_refused(run("render", record, "--plot-width", "column"), "'page', 'double', 'single'")
    for command in ("sweep", "reproduce", "walk", "compare", "gait", "bifurcation", "basin", "stability"):
        assert "--plot-width [page|double|single]" in run(command, "--help").stdout


def test_a_failed_plot_leaves_record_and_video(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, drawings: Drawings
) -> None:
    def plot_walk(*_: object) -> None:
        raise RuntimeError("out of\nink")

    monkeypatch.setattr(plots, "plot_walk", plot_walk)
    out, plot, film = tmp_path / "walk.npz", tmp_path / "walk.png", tmp_path / "walk.mp4"
    words = ("walk", "level", "--steps", 1, "--out", out, "--plot", plot, "--video", film)
    result = run(*words, "--json")
    assert result.exit_code == 1
    assert result.stderr == f"Error: the plot {plot} was not written: RuntimeError: out of ink\n"
    assert json.loads(result.stdout)["files"] == {"record": str(out), "video": str(film)}
    assert Walk.load(out).outcome == "finished"
    assert [name for name, _ in drawings.calls] == ["render_video"]


def test_ctrl_c_in_a_drawing_leaves_the_record(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, drawings: Drawings
) -> None:
    def plot_walk(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(plots, "plot_walk", plot_walk)
    out, plot, film = tmp_path / "walk.npz", tmp_path / "walk.png", tmp_path / "walk.mp4"
    result = run("walk", "level", "--steps", 1, "--out", out, "--plot", plot, "--video", film)
    assert result.exit_code == 130
    assert f"wrote {out}" in result.stdout
    assert result.stderr == f"Error: the plot {plot} was not written: interrupted\n"
    assert not drawings.calls


def test_a_video_without_opengl_is_warned_of_and_comes_last(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, drawings: Drawings
) -> None:
    out, plot, film = tmp_path / "walk.npz", tmp_path / "walk.png", tmp_path / "walk.mp4"

    def render_video(*_: object, **__: object) -> None:
        assert Walk.load(out).outcome == "finished"
        assert plot.exists()
        raise RenderError("no OpenGL platform works here. On Debian or Ubuntu install libegl1 and libgl1-mesa-dri")

    monkeypatch.setattr(video, "render_video", render_video)
    monkeypatch.setattr(gl, "gl_available", lambda: None)
    result = run("walk", "level", "--steps", 1, "--out", out, "--plot", plot, "--video", film)
    assert result.exit_code == 2
    warning, error = result.stderr.splitlines()
    assert warning.startswith("Warning: there is no OpenGL platform")
    assert error.startswith(f"Error: the video {film} was not written")
    assert "libegl1" in error
    assert result.stdout.endswith(f"wrote {out}\nwrote {plot}\n")
    assert [name for name, _ in drawings.calls] == ["plot_walk"]


@pytest.mark.slow
def test_a_process_without_opengl_writes_the_record(tmp_path: Path) -> None:
    words = ("walk", "level", "--steps", 1, "--out", "walk.npz", "--video", "walk.mp4", "--json")
    result = run_process(*words, cwd=tmp_path, MUJOCO_GL="disable")
    assert result.returncode == 2
    assert "Error: the video walk.mp4 was not written: MUJOCO_GL=disable" in result.stderr
    assert "Traceback" not in result.stderr
    assert json.loads(result.stdout)["files"] == {"record": "walk.npz"}
    assert Walk.load(tmp_path / "walk.npz").outcome == "finished"
    assert not (tmp_path / "walk.mp4").exists()


# ---- refusals --------------------------------------------------------------------------------------------------------


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
    "no gait uphill": (("--imitate-slope-deg", -1), "no passive gait on a slope of -1 degrees"),
    "no gait so steep": (("--imitate-slope-deg", 30), "no passive gait on a slope of 30 degrees"),
    "no passive gait on the level": (("level", "--controller", "passive"), "no passive gait on a slope of 0 degrees"),
    "gain without controller": (("--controller", "passive", "--position-gain", 5), "--position-gain is for"),
    "switch without controller": (("--controller", "passive", "--estimate-update"), "--estimate-update is for"),
    "gains of another": (("--controller", "passivity", "--position-gain", 5), "--position-gain is for"),
    "switch of another": (("--controller", "limit-cycle", "--estimate-update"), "limit-cycle has no such thing"),
    "gain of the adaptive": (
        ("--gain", "gain=5"),
        "adaptive has no such gain; valid are position_gain=5.0, velocity_gain=12.0",
    ),
    "source of the passive": (("--controller", "passive", "--slope-source", "local"), "--slope-source is for"),
    "source of the library": (("--controller", "library", "--slope-source", "local"), "--slope-source is for"),
    "unknown gain": (
        ("--controller", "energy-constraint", "--gain", "mu=2"),
        "valid are gain=5.0, ratio=-2.3, singular_band=0.1.",
    ),
    "no gain's field": (("--controller", "passivity", "--gain", "initial_slope_estimate=2"), "valid are gain=5.0."),
    "gain without name": (("--controller", "passivity", "--gain", 3), "expected NAME=VALUE"),
    "gain not a number": (
        ("--controller", "passivity", "--gain", "gain=much"),
        "--gain gain = 'much': must be a finite number",
    ),
    "gain of zero": (("--controller", "passivity", "--gain", "gain=0"), "gain = 0.0: must be from 1e-06"),
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
    "unknown controller": (("--controller", "pid"), "'--controller'"),
    "unknown state": (("--initial", "run"), "'gait', 'rest' or four numbers"),
    "three numbers": (("--initial", "1,2,3"), "'gait', 'rest' or four numbers"),
    "state not a number": (("--initial", "0,0,nan,0"), "'gait', 'rest' or four numbers"),
    "no timestep": (("--timestep", 0), "expected a number from 1e-06 to 0.004 s"),
    "long timestep": (("--timestep", 0.1), "expected a number from 1e-06 to 0.004 s"),
    "control period": (("--control-period", 1.5e-4), "multiple of the timestep"),
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


def assert_refused(result: Result, reason: str) -> None:
    """Exit status 2, nothing on stdout, and an error in one line."""
    assert (result.exit_code, result.stdout) == (2, "")
    *usage, error = result.stderr.splitlines()
    assert error.startswith("Error: ")
    assert reason in error
    assert not usage or usage[0].startswith("Usage: ")


@pytest.mark.usefixtures("no_walk")
@pytest.mark.parametrize(("words", "reason"), REFUSED.values(), ids=REFUSED.keys())
def test_walk_refuses_before_it_walks(
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


@pytest.mark.usefixtures("no_walk")
@pytest.mark.parametrize(("option", "name"), [("--out", "w.npz"), ("--plot", "w.png"), ("--video", "w.mp4")])
def test_walk_refuses_outputs_that_cannot_be_written(option: str, name: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    (tmp_path / name).mkdir()
    assert_refused(run("walk", option, tmp_path / "file" / name), "there is no folder")
    assert_refused(run("walk", option, tmp_path / name), "is a folder")


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="needs a folder that takes no file, from root neither")
@pytest.mark.usefixtures("no_walk")
def test_walk_refuses_a_folder_that_takes_no_files() -> None:
    assert_refused(run("walk", "--out", "/proc/self/walk.npz"), "cannot be written")


def test_refusal_in_a_process(tmp_path: Path) -> None:
    result = run_process("walk", "incline:slope_deg=50", cwd=tmp_path)
    assert (result.returncode, result.stdout) == (2, "")
    assert result.stderr.startswith("Error: terrain incline: slope_deg")
    assert result.stderr.count("\n") == 1


# ---- compare ---------------------------------------------------------------------------------------------------------


def test_compare_prints_both_engines_and_writes_both_records(tmp_path: Path, drawings: Drawings) -> None:
    out, plot = tmp_path / "both.npz", tmp_path / "both.png"
    result = run("compare", "level", "--steps", 2, "--out", out, "--plot", plot)
    assert (result.exit_code, complaints(result)) == (0, "")
    records = [Walk.load(tmp_path / f"both_{engine}.npz") for engine in ("mujoco", "hybrid")]
    assert [record.settings["engine"] for record in records] == ["mujoco", "hybrid"]
    for record in records:
        assert f"{record.cost_of_transport:.4f}" in result.stdout
    difference = records[0].cost_of_transport - records[1].cost_of_transport
    assert f"{difference:+.3g}" in result.stdout
    assert f"{100 * difference / records[1].cost_of_transport:+.2f}" in result.stdout
    assert "The engines agree at all 2 touchdowns" in result.stdout
    names = [tmp_path / "both_mujoco.npz", tmp_path / "both_hybrid.npz", plot]
    assert result.stdout.endswith("".join(f"wrote {name}\n" for name in names))
    assert drawings.calls == [("plot_comparison", {"steps": 2})]


@pytest.mark.slow
def test_compare_as_json_in_a_process(tmp_path: Path) -> None:
    words = ("compare", "stairs:rise=0.045,first=1.0,count=1", "--steps", 3, "--json")
    result = run_process(*words, cwd=tmp_path)
    assert (result.returncode, complaints(result)) == (0, "")
    printed = json.loads(result.stdout)
    assert printed["parting"]["touchdown"] == 3
    assert "riser" in printed["parting"]["causes"][0]
    assert printed["measures"]["steps"] == {"mujoco": 3, "hybrid": 3, "difference": 0, "difference_percent": 0.0}
    assert len(printed["touchdowns"]["x"]) == 3
    assert printed["settings"]["hybrid"]["engine"] == "hybrid"
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("terrain", [*PRESETS[:-1], "recorded:file=hill.csv,seed=2", "hill.csv", "hill.toml"])
def test_compare_walks_every_terrain(terrain: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("hill.csv").write_text("x,z\n0,0\n0.6,0.01\n5,-0.1\n", encoding="utf-8")
    Path("hill.toml").write_text("segments = [[0.5, 0.0], [2.0, 2.0, -0.01]]\n", encoding="utf-8")
    result = run("compare", terrain, "--steps", 2)
    assert (result.exit_code, complaints(result)) == (0, "")
    assert "cost of transport" in result.stdout
    assert "The engines agree at all 2 touchdowns" in " ".join(result.stdout.split())


def test_compare_shows_falls_of_both(tmp_path: Path) -> None:
    result = run("compare", "level", "--controller", "passive", "--initial=-0.19,0.19,0.3,0")
    assert (result.exit_code, complaints(result)) == (0, "")
    assert re.search(r"outcome +fell +fell", result.stdout)


@pytest.mark.usefixtures("no_walk")
@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("levle",), "level"),
        (("level", "--timestep", 0), "timestep"),
        (("level", "--steps", 0), "--steps"),
        (("level", "--out", "walk.txt"), "must end in .npz"),
        (("level", "--engine", "hybrid"), "No such option"),
        (("level", "--controller", "passive", "--position-gain", 3), "passive has no such thing"),
        (("no.csv",), "no.csv"),
    ],
)
def test_compare_refuses_before_it_walks(
    words: tuple[object, ...], reason: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert_refused(run("compare", *words), reason)
    assert not list(tmp_path.iterdir())


# ---- gait ------------------------------------------------------------------------------------------------------------


def test_gait_prints_the_cycle(drawings: Drawings, tmp_path: Path) -> None:
    plot = tmp_path / "gait.pdf"
    result = run("gait", "--slope-deg", 2, "--plot", plot)
    assert (result.exit_code, result.stderr) == (0, "")
    for number in ("-0.19008478", "1.10317583", "0.76484357", "0.377884", "0.494067", "51.31078", "0.27555", "0.53365"):
        assert number in result.stdout
    assert result.stdout.endswith(f"wrote {plot}\n")
    assert drawings.calls == [("plot_gait", {"slope": pytest.approx(math.radians(2))})]


def test_gait_with_knees(tmp_path: Path) -> None:
    plot = tmp_path / "knees.png"
    result = run("gait", "--robot", "kneed", "--slope-deg", 2.5, "--plot", plot)
    assert (result.exit_code, result.stderr) == (0, "")
    for number in ("-0.24447693", "1.08907369", "0.35377631", "0.52706293", "0.61464642", "2.561", "0.70998", "yes"):
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
        (("--robot", "kneed", "--leg-mass", 4), "--leg-mass is for --robot compass; kneed has no such thing."),
        (("--robot", "kneed", "--slope-deg", -1), "walks only downhill"),
        (("--robot", "knee"), "'knee'; expected compass, kneed, wheel, halved-rods, or a .toml or .xml file."),
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


# ---- render ----------------------------------------------------------------------------------------------------------


def test_render_draws_beside_the_record(record: Path, drawings: Drawings) -> None:
    words = ("--hide", "caption", "--flag", "contactpoint", "--flag", "no-skin", "--start", 0.1, "--stop", 0.3)
    result = run("render", record, *words)
    film = record.with_suffix(".mp4")
    assert (result.exit_code, result.stdout, result.stderr) == (0, f"wrote {film}\n", "")
    ((name, settings),) = drawings.calls
    assert name == "render_video"
    assert (settings["width"], settings["height"], settings["fps"], settings["camera"]) == (1280, 720, 30, "track")
    assert (settings["slow_motion"], settings["start"], settings["stop"]) == (1.0, 0.1, 0.3)
    assert (settings["hide"], settings["flags"]) == (("caption",), ("contactpoint", "no-skin"))


def test_render_draws_where_it_is_told(record: Path, drawings: Drawings, tmp_path: Path) -> None:
    film, plot = tmp_path / "other.mp4", tmp_path / "other.png"
    assert run("render", record, film, "--plot", plot, "--quiet").output == ""
    assert [name for name, _ in drawings.calls] == ["plot_walk", "render_video"]
    assert film.exists()
    assert run("render", record, "--no-video", "--plot", plot).stdout == f"wrote {plot}\n"
    assert [name for name, _ in drawings.calls[2:]] == ["plot_walk"]


def _truncated(whole: bytes) -> bytes:
    return whole[: len(whole) // 2]


def _foreign(_: bytes) -> bytes:
    return b"no record"


@pytest.mark.parametrize("change", [_truncated, _foreign])
def test_render_refuses_files_that_are_no_records(
    change: Callable[[bytes], bytes], record: Path, tmp_path: Path, drawings: Drawings
) -> None:
    path = tmp_path / "walk.npz"
    path.write_bytes(change(record.read_bytes()))
    assert_refused(run("render", path), "no walk's record")
    assert not drawings.calls


def test_render_refuses(record: Path, tmp_path: Path, drawings: Drawings) -> None:
    assert_refused(run("render", tmp_path / "walk.npz"), "there is no such file")
    assert_refused(run("render", record, tmp_path / "walk.avi"), "must end in .mp4 or .gif")
    assert_refused(run("render", record, tmp_path / "nowhere" / "walk.mp4"), "there is no folder")
    assert_refused(run("render", record, "--no-video"), "--no-video")
    assert_refused(run("render", record, "--video-size", "1x1"), "even pixels")
    assert not drawings.calls


# ---- stability -------------------------------------------------------------------------------------------------------


def test_stability_tells_theorem_1(tmp_path: Path) -> None:
    record, plot = tmp_path / "walk.npz", tmp_path / "stability.png"
    words = ("--engine", "hybrid", "--steps", 4, "--initial-slope-estimate-deg", 3, "--quiet", "--out", record)
    assert run("walk", "level", *words).exit_code == 0
    result = run("stability", record, "--plot", plot)
    assert (result.exit_code, result.stderr) == (0, "")
    assert "steps where (24) holds" in result.stdout
    assert result.stdout.endswith(f"wrote {plot}\n")
    assert plot.stat().st_size > 10_000
    printed = json.loads(run("stability", record, "--json").stdout)
    found = stability(mjbiped.Walk.load(record))
    assert printed["condition_24_smallest_for_any_constants"] == found.condition_floor.min() > 1.0
    assert (printed["condition_24_holds_steps"], printed["errors_26_holds_steps"], printed["steps"]) == (0, 3, 4)


def test_stability_refuses(record: Path, tmp_path: Path) -> None:
    assert_refused(run("stability", tmp_path / "none.npz"), "there is no such file")
    assert_refused(run("stability", record, "--plot", tmp_path / "walk.gif"), "must end in .png")
