"""`mjbiped walk`, `compare`, `render` and `view`: what reaches a walk, what is printed and written, and how it ends."""

import json
import math
import re
import shlex
import signal
from dataclasses import replace
from pathlib import Path
from typing import Any

import own_controllers
import pytest
from command_line import Drawings, complaints, python, ran, run, run_process
from PIL import Image

import mjbiped
from mjbiped import RenderError, Walk, plotting
from mjbiped.cli.walkers import next_ground
from mjbiped.control.controller import Controller
from mjbiped.exchange.mjcf import export_scene
from mjbiped.plotting import walk as plots
from mjbiped.records import measures
from mjbiped.records.columns import Recorder
from mjbiped.records.summary import MEASURES
from mjbiped.robots.robot import Robot

Asked = tuple[Controller, mjbiped.Terrain, dict[str, Any]]


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[Asked]:
    """Controller, terrain and settings of each walk that a command would make; none is made."""
    found: list[Asked] = []

    def walk(controller: Controller, terrain: mjbiped.Terrain, **settings: Any) -> None:
        found.append((controller, terrain, settings))
        raise mjbiped.InputError("not walked")

    monkeypatch.setattr("mjbiped.walk", walk)
    return found


def law_of(asked: list[Asked], line: str) -> dict[str, Any]:
    """What the controller says of itself with which a command line would walk."""
    assert run("walk", *shlex.split(line)).stderr == "Error: not walked\n"
    return dict(asked[-1][0].describe())


# ---- options ---------------------------------------------------------------------------------------------------------


def test_options_reach_controller_robot_and_engine(tmp_path: Path) -> None:
    out = tmp_path / "walk.npz"
    gains = ("--position-gain", 6, "--velocity-gain", 11, "--adaptation-gain", 0.2, "--initial-slope-estimate-deg", 0.5)
    switches = ("--replanning-delay", "none", "--no-estimate-update", "--imitate-slope-deg", 1.5, "--hip-mass", 3)
    times = ("--timestep", 5e-4, "--control-period", 1e-3, "--distance", 0.2, "--initial", "-0.15,0.15,0.9,0.7")
    words = (*gains, *switches, *times, "--no-lands", "--seed", 7, "--out", out, "--quiet")
    assert ran("walk", "random:slope_deg=-1..1", *words) == ""
    walk = Walk.load(out)
    settings, law = walk.settings, walk.settings["controller"]
    assert (law["position_gain"], law["velocity_gain"], law["adaptation_gain"]) == (6.0, 11.0, 0.2)
    assert (law["replanning_delay"], law["estimate_update"]) == (None, False)
    assert law["initial_slope_estimate"] == pytest.approx(math.radians(0.5))
    assert law["gait"]["slope"] == pytest.approx(math.radians(1.5))
    assert law["robot"] == settings["robot"] == mjbiped.Compass(hip_mass=3.0).to_dict()
    assert (settings["timestep"], settings["control_period"], settings["lands"]) == (5e-4, 1e-3, False)
    assert (settings["steps"], settings["distance"], settings["initial"]) == (None, 0.2, [-0.15, 0.15, 0.9, 0.7])
    assert walk.terrain == mjbiped.Terrain.random(seed=7, slope_deg=(-1.0, 1.0))


LAWS: dict[str, dict[str, Any]] = {
    "--controller energy-constraint --gain ratio=-2 --gain gain=9 --slope-source none":
        {"name": "EnergyConstraintController", "ratio": -2.0, "gain": 9.0, "slope_source": "none"},
    "--gain position_gain=7 --gain replanning_delay=none --gain estimate_update=false":
        {"position_gain": 7.0, "replanning_delay": None, "estimate_update": False},
    "--controller spread.py:HipSpread --gain stiffness=0.45 --initial rest":
        {"name": "HipSpread", "stiffness": 0.45, "spread": 0.4},
}  # fmt: skip
ROBOTS: dict[str, Robot] = {
    "": mjbiped.Compass(),
    "--sole 0.12": mjbiped.Compass(sole=(0.12, 0.12)),
    "--robot kneed --sole 0.05,0.15 --hip-mass 7": mjbiped.KneedBiped(hip_mass=7.0, sole=(0.05, 0.15)),
    # a rod's inertia follows its mass
    "--robot halved-rods --shank-mass 2": replace(
        mjbiped.KneedBiped.halved_rods(), shank_mass=2.0, shank_inertia=1 / 24
    ),
    "--robot mine.toml --gravity 3.7": mjbiped.KneedBiped(thigh_mass=3.5, gravity=3.7),
    "--robot heavy.toml": mjbiped.Compass(leg_mass=3.5),
    "--robot mine.xml --sole 0.1": mjbiped.Compass(hip_mass=2.0, sole=(0.1, 0.1)),
}


@pytest.mark.parametrize("line", LAWS)
@pytest.mark.usefixtures("folder")
def test_options_reach_every_controller(line: str, asked: list[Asked]) -> None:
    law = law_of(asked, f"incline:slope_deg=2 {line}")
    assert {key: law[key] for key in LAWS[line]} == LAWS[line]


@pytest.mark.parametrize("line", ROBOTS)
def test_robots_by_name_file_and_parameter(line: str, asked: list[Asked], folder: Path) -> None:
    (folder / "mine.toml").write_text('kind = "kneed"\nthigh_mass = 3.5\n')
    (folder / "heavy.toml").write_text("leg_mass = 3.5\n")
    export_scene(mjbiped.Compass(hip_mass=2.0), mjbiped.Terrain.level(), folder / "mine.xml")
    law_of(asked, f"incline:slope_deg=2 --controller passive {line}")
    assert asked[-1][2]["robot"] == ROBOTS[line]


@pytest.mark.usefixtures("asked")
def test_limits_in_an_mjcf_file_are_told(folder: Path) -> None:
    export_scene(mjbiped.Compass(), mjbiped.Terrain.level(), folder / "mine.xml")
    text = (folder / "mine.xml").read_text()
    (folder / "mine.xml").write_text(text.replace('name="hip" tendon', 'name="hip" forcerange="-9 9" tendon'))
    words = "incline:slope_deg=2", "--robot", "mine.xml", "--controller", "passive"
    told = run("walk", *words).stderr
    assert "(motor hip 9 N m)" in told
    assert "limits" not in run("walk", *words, "--disturb", "torque_limit=9,9").stderr
    assert "give --disturb torque_limit=X, or one number for each of ankle, hip" in told


@pytest.mark.parametrize("text", ["random", "random:seed=4", "random:roughness=0.001"])
def test_a_seed_is_that_of_the_random_ground_and_the_window_counts_on(text: str, asked: list[Asked]) -> None:
    law_of(asked, f"{text} --seed 4")
    roughness = 0.001 if "roughness" in text else 0.0
    assert asked[-1][1] == mjbiped.Terrain.random(seed=4, roughness=roughness)
    following = next_ground(text, 4)
    assert following is not None
    assert [following(), following()] == [mjbiped.Terrain.random(seed=seed, roughness=roughness) for seed in (5, 6)]
    assert next_ground("mixed", None) is None


# ---- what is printed and written -------------------------------------------------------------------------------------


def test_a_table_and_the_files(tmp_path: Path, drawings: Drawings, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)
    out, plot, film = tmp_path / "[b].npz", tmp_path / "a.png", tmp_path / "a.mp4"
    out.write_text("an older file is replaced")
    words = ("walk", "mixed", "--engine", "hybrid", "--steps", 1, "--out", out, "--plot", plot, "--video", film)
    look = "--slow-motion 2 --fps 25 --camera side --video-size 320x200 --hide shadows,ghost --flag no-skin"
    printed = ran(*words, *look.split())
    lines = printed.splitlines()
    assert {label for label, *_ in MEASURES} <= {line.strip().split("  ")[0] for line in lines}  # none is broken
    assert f"{measures.summary(Walk.load(out))['cost_of_transport']:.4f}" in printed
    assert printed.endswith(f"wrote {out}\nwrote {plot}\nwrote {film}\n")
    size = {"width": 320, "height": 200, "fps": 25, "camera": "side", "slow_motion": 2.0, "start": None, "stop": None}
    shows = {"hide": ("shadows,ghost",), "flags": ("no-skin",), "progress": True}
    walk = Walk.load(out)
    assert drawings == [("walk", walk, {"panels": None}), ("video", walk, {**size, **shows})]


def test_json_is_the_summary_and_repeats_the_walk(tmp_path: Path) -> None:
    words = ["random:seed=3,slope_deg=-1..2", "--engine", "hybrid", "--steps", "2", "--initial", "rest", "--quiet"]
    one, other = tmp_path / "it's.npz", tmp_path / "again.npz"
    printed = json.loads(ran("walk", *words, "--json", "--out", one))
    walk = Walk.load(one)
    assert (printed.pop("files"), printed.pop("settings")) == ({"record": str(one)}, walk.settings)
    assert printed == json.loads(json.dumps(walk.summary()))
    assert printed["verdict"] == printed["outcome"] == "finished"
    again = shlex.split(walk.settings["command"].replace(shlex.quote(str(one)), str(other)))
    ran(*again[1:])
    assert Walk.load(other) == walk


def test_a_fall_is_a_result(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo may write its log
    words = ("walk", "level", "--controller", "passive", "--initial", "0.1,0.1,1,1", "--json", "--timestep", 5e-4)
    printed = json.loads(ran(*words))
    assert (printed["outcome"], printed["steps"], printed["cost_of_transport"]) == ("fell", 0, None)


def test_a_narrow_terminal_of_plain_ascii_and_a_refusal_in_processes(tmp_path: Path) -> None:
    words = ("walk", "random", "--engine", "hybrid", "--steps", 1)
    result = run_process(*words, cwd=tmp_path, COLUMNS="50", PYTHONIOENCODING="ascii")
    assert (result.returncode, complaints(result)) == (0, "")
    assert max(map(len, result.stdout.splitlines())) <= 50
    refused = run_process("walk", "incline:slope_deg=50", cwd=tmp_path)
    assert (refused.returncode, refused.stdout, refused.stderr.count("\n")) == (2, "", 1)
    assert refused.stderr.startswith("Error: terrain incline: slope_deg")


def test_compare_tells_of_both(tmp_path: Path, drawings: Drawings, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    out, plot = tmp_path / "both.npz", tmp_path / "both.png"
    printed = ran("compare", "level", "--steps", 2, "--out", out, "--plot", plot)
    records = [Walk.load(tmp_path / f"both_{engine}.npz") for engine in ("mujoco", "hybrid")]
    assert [record.settings["engine"] for record in records] == ["mujoco", "hybrid"]
    mine, other = (record.cost_of_transport for record in records)
    shown = rf"absolute +{mine:.4f} +{other:.4f} +\{mine - other:+.3g} +\{100 * (mine - other) / other:+.2f}"
    assert re.search(shown, printed)
    assert re.search(r"foothold +\S+ +2 +1 +mm\s", printed)  # largest difference, touchdown, limit
    assert "The engines agree at all 2 touchdowns" in printed
    names = [tmp_path / "both_mujoco.npz", tmp_path / "both_hybrid.npz", plot]
    assert printed.endswith("".join(f"wrote {name}\n" for name in names))
    assert [module for module, *_ in drawings] == ["comparison"]


def test_render_draws_beside_the_record_or_where_it_is_told(folder: Path, drawings: Drawings) -> None:
    words = "--hide caption --flag contactpoint --start 0.1 --stop 0.3"
    assert ran("render", "walk.npz", *words.split()) == "wrote walk.mp4\n"
    ((module, _, settings),) = drawings
    size = {"width": 1280, "height": 720, "fps": 30, "slow_motion": 1.0, "start": 0.1, "stop": 0.3}
    assert (module, {key: settings[key] for key in size}) == ("video", size)
    assert (settings["hide"], settings["flags"]) == (("caption",), ("contactpoint",))
    assert ran("render", "walk.npz", "other.mp4", "--plot", "other.png", "--quiet") == ""
    assert [module for module, *_ in drawings[1:]] == ["walk", "video"]
    assert ran("render", "walk.npz", "--no-video", "--plot", "other.png") == "wrote other.png\n"
    assert len(drawings) == 4


@pytest.mark.usefixtures("folder")
def test_a_plot_is_as_wide_as_asked_for_and_has_the_panels() -> None:
    words = ("render", "walk.npz", "--no-video", "--plot", "narrow.png", "--plot-width", "single")
    ran(*words, "--panels", "torque,phase")
    with Image.open("narrow.png") as picture:
        assert picture.width == 1050  # 3.5 in of 300 dots
        assert picture.height < 1400  # two panels
    assert plotting.width() is plotting.WIDTHS["page"]


# ---- endings ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupted_walk_is_kept(
    number: signal.Signals, status: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, drawings: Drawings
) -> None:
    add, count = Recorder.add, iter(range(1000))

    def interrupted(*arguments: Any) -> None:
        add(*arguments)
        if next(count) == 3:
            signal.raise_signal(number)

    monkeypatch.setattr(Recorder, "add", interrupted)
    out, plot = tmp_path / "walk.npz", tmp_path / "walk.png"
    result = run("walk", "--timestep", 2e-4, "--out", out, "--plot", plot, "--json")
    assert result.exit_code == status
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL
    assert result.stderr == f"Error: walk interrupted; what was walked is in {out}\n"
    walk = Walk.load(out)
    assert walk.outcome == "interrupted"
    assert len(walk.samples["time"]) > 60  # of some 500 physics steps each time
    assert json.loads(result.stdout)["files"] == {"record": str(out)}
    assert not drawings


PROGRAM = """
import mjbiped, signal, sys, time
from pathlib import Path
from mjbiped.cli import main as cli
from mjbiped.utils.files import written_whole
def walk(*_, **__):
    with written_whole(Path(sys.argv[1])) as unfinished:
        unfinished.write_text("half")
        try:
            signal.raise_signal(signal.SIGTERM)
        finally:
            assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL
        time.sleep(600.0)
mjbiped.walk = walk
cli.main(["walk", "level"])
"""


def test_sigterm_ends_the_process_cleanly(tmp_path: Path) -> None:
    """In the midst of a file, with the exit status that shells have; a second one ends it at once."""
    done = python("-c", PROGRAM, tmp_path / "walk.npz", cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (143, "", "Error: interrupted\n")
    assert not [*tmp_path.iterdir()]


@pytest.mark.usefixtures("folder")
def test_a_controller_that_fails_keeps_the_walk_so_far() -> None:
    """In a comparison between the milliseconds at which MuJoCo asks, until the foot is about to land."""
    body = "if 0.0 < t < 0.3 and abs(1e3 * t - round(1e3 * t)) > 1e-6:\n    raise KeyError('gone')\nreturn 0.0, 0.0"
    own_controllers.write(Path(), "failing.py", own_controllers.law(body))
    words = ("trail.csv", "--controller", "failing.py:Law", "--steps", 1, "--out", "both.npz")
    result = run("compare", *words)
    assert (result.exit_code, result.stdout) == (1, "wrote both_mujoco.npz\nwrote both_hybrid.npz\n")
    assert "failing.py, line 7, in torque: raise KeyError('gone')) (engine hybrid); what was walked" in result.stderr
    outcomes = [Walk.load(Path(f"both_{engine}.npz")).outcome for engine in ("mujoco", "hybrid")]
    assert outcomes == ["finished", "interrupted"]
    result = run("walk", *words, "--engine", "hybrid")
    assert result.exit_code == 1
    assert re.match(r"Error: Law failed at 0\.0.* what was walked is in both.npz\n", result.stderr)
    assert "interrupted" in result.stdout
    assert Walk.load(Path("both.npz")).outcome == "interrupted"


FAILURES = [
    (RuntimeError("out of\nink"), 1, "RuntimeError: out of ink"),
    (RenderError("no samples"), 2, "no samples"),
    (KeyboardInterrupt(), 130, "interrupted"),
]


@pytest.mark.usefixtures("folder", "drawings")
@pytest.mark.parametrize(("failure", "status", "said"), FAILURES)
def test_other_files_are_left(failure: BaseException, status: int, said: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A drawing that fails leaves the files of the walk."""

    def plot_walk(*_: object, **__: object) -> None:
        raise failure

    monkeypatch.setattr(plots, "plot_walk", plot_walk)
    words = ("walk", "level", "--engine", "hybrid", "--steps", 1, "--out", "a.npz", "--plot", "a.png")
    result = run(*words, "--video", "a.mp4", "--json")
    assert result.exit_code == status
    assert result.stderr == f"Error: the plot a.png was not written: {said}\n"
    filmed = {} if status == 130 else {"video": "a.mp4"}
    assert json.loads(result.stdout)["files"] == {"record": "a.npz", **filmed}
    assert Walk.load("a.npz").outcome == "finished"
