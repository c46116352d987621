"""`mjbiped sweep`, `reproduce`, `figures`, `report` and `export`: what they write and print, and how they end."""

import csv
import json
import re
from pathlib import Path

import click
import mujoco
import pytest
from command_line import ran, run

import mjbiped
from mjbiped.cli import export
from mjbiped.cli.main import main
from mjbiped.control.controller import Unpowered
from mjbiped.exchange.ros import urdf_of
from mjbiped.plotting.style import new_figure, save_figure
from mjbiped.studies import run as running
from mjbiped.studies.reproduction import figures, section_5
from mjbiped.studies.reproduction import reproduce as whole

STUDY = """
engine = "hybrid"
steps = 3
controller = [{ name = "passive" }, { position_gain = [3, 6] }]
terrain = { name = "incline", slope_deg = [2, -2] }
"""


@pytest.fixture
def study(tmp_path: Path, studies_in_threads: None) -> Path:
    path = tmp_path / "slopes.toml"
    path.write_text(STUDY)
    return path


def test_a_sweep_leaves_its_files(study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)
    text = ran("sweep", study)
    folder = tmp_path / "slopes"
    assert len([*csv.DictReader((folder / "study.csv").read_text().splitlines())]) == 6
    assert list(folder.glob("*.png"))
    for shown in (
        r"finished +5 +83\.3\s",
        r"no passive gait on ",
        r"best: passive, slope deg 2 \(100 % of 1 finished, median cost of transport 0\.0000, first cell 0\)\n",
    ):
        assert re.search(shown, text), shown
    printed = json.loads(ran("sweep", study, "--json"))
    assert (printed["walks"], printed["outcomes"]) == (6, {"finished": 5, "failed": 1})
    assert ran("report", folder) == f"wrote {folder / 'report.html'}\n"
    assert "--no-video is for the report of a walk" in run("report", folder, "--no-video").stderr
    study.write_text(STUDY.replace("steps = 3", "steps = 4"))
    changed = run("sweep", study)
    assert (changed.exit_code, "study.steps was 3, is 4" in changed.stderr) == (2, True)
    assert ran("sweep", study, "--fresh", "--quiet") == ""


def test_a_dry_run_tells_what_it_takes_and_leaves_nothing(study: Path, tmp_path: Path) -> None:
    assert re.match(r"6 walks: about \d+ s in 1 process \(", ran("sweep", study, "--dry-run", "--workers", 1))
    assert list(tmp_path.iterdir()) == [study]
    told, more = (json.loads(ran("sweep", study, "--dry-run", "--json", *words)) for words in ((), ("--trajectories",)))
    assert (told["walks"], told["tried"]) == (6, running.TRIED)
    assert more["bytes"] > 10 * told["bytes"] > 0  # of samples every 5 ms


def test_an_interrupted_sweep_says_how_to_go_on(study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(running, "walk_cells", interrupted)
    result = run("sweep", study, "--out", tmp_path / "out")
    assert (result.exit_code, "the same command goes on" in result.stderr) == (130, True)


def test_a_sweep_over_the_limits_of_a_walk_has_columns_for_both(study: Path, tmp_path: Path) -> None:
    """What is asked for, and the measure of the same name."""
    study.write_text('engine = "hybrid"\nsteps = [2, 3]\ndistance = [0.5, 9]\nterrain = { name = "level" }\n')
    ran("sweep", study)
    rows = list(csv.DictReader((tmp_path / "slopes" / "study.csv").read_text().splitlines()))
    found = [(row["limit.steps"], row["limit.distance"], row["steps"]) for row in rows]
    assert found == [("2", "0.5", "2"), ("2", "9", "2"), ("3", "0.5", "2"), ("3", "9", "3")]


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch, studies_in_threads: None) -> None:
    """A reproduction of the adaptive controller with one zeta, of the fitted methods, without MuJoCo and processes."""
    all_of_table_2 = whole.table_2
    monkeypatch.setattr(section_5, "DELAYS", (0.6,))
    adaptive = lambda: [entry for entry in all_of_table_2() if entry.values["method"] == "adaptive"]  # noqa: E731
    monkeypatch.setattr(whole, "table_2", adaptive)
    monkeypatch.setattr(whole, "in_mujoco", lambda *_: [])
    monkeypatch.setattr(section_5, "BLIND", {"PBC": section_5.BLIND["PBC"]})
    # these take seconds to draw, and have tests of their own
    for name in ("plot_walk", "plot_figure_5", "plot_figure_6"):
        monkeypatch.setattr(figures, name, lambda _, path: save_figure(new_figure(1.0), path))


@pytest.mark.slow
@pytest.mark.usefixtures("small")
def test_page_table_and_figures_of_the_reproduction(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = ran("reproduce", "--out", tmp_path / "walks", "--report", tmp_path / "page", "--quick")
    tables = [f"reproduction{part}.csv" for part in ("", "_gains", "_grounds")]
    for name in ("reproduction.md", "tables/reproduction.md", *tables, "images/reproduction_fig_4_mixed_hybrid.png"):
        assert (tmp_path / "page" / name).is_file()
        assert name in text.replace("\n", "")
    assert (tmp_path / "walks" / "figures" / "reproduction_table_3.pdf").stat().st_size > 5_000
    assert "0.03492" in text  # c_mt on level ground
    first = (tmp_path / "page" / "reproduction.md").read_bytes()
    monkeypatch.setattr(whole, "draw", lambda *_: [])
    printed = json.loads(ran("reproduce", "--out", tmp_path / "walks", "--quick", "--json"))
    assert (tmp_path / "walks" / "reproduction.md").read_bytes() == first
    assert printed["failed"] == []
    assert {"claim", "source", "holds", "found", "of", "engine", "group"} == set(printed["checks"][0])


def test_figures_are_files_of_their_names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One that fails does not stop the others; the summary tells each command."""
    wheel = "gait --robot wheel --slope-deg 5"
    last = "return-map --robot wheel --slope-deg 5 --points 9"
    shown = {"steep": "gait --slope-deg 80", "wheel": wheel, "last": last}
    monkeypatch.setattr(export, "SET", shown)
    folder = tmp_path / "for slides"
    result = run("figures", folder, "--plot-width", "single")
    assert result.exit_code == 2
    assert "Error: no passive gait on a slope of 80 degrees" in result.stderr
    assert "mjbiped gait failed" in result.stderr
    assert f"mjbiped {wheel} --plot '{folder / 'wheel.pdf'}'" in result.stdout
    assert result.stdout.endswith(f"wrote {folder / 'wheel.pdf'}\nwrote {folder / 'last.pdf'}\n")
    assert sorted(path.name for path in folder.iterdir()) == ["last.pdf", "wheel.pdf"]


@pytest.mark.parametrize("name", export.SET)
def test_the_commands_of_the_set_can_be_read(name: str, tmp_path: Path) -> None:
    word, *words = export.SET[name].format(folder=tmp_path).split()
    context = main.commands[word].make_context(word, [*words, "--plot", str(tmp_path / f"{name}.pdf"), "--quiet"])
    assert isinstance(context, click.Context)


def test_the_report_stands_beside_the_record_or_where_it_shall(folder: Path) -> None:
    assert ran("report", "walk.npz", "--no-video") == "wrote walk.html\n"
    assert ran("report", "walk.npz", "--no-video", "--out", "other.html", "--quiet") == ""
    assert (folder / "other.html").read_bytes() == (folder / "walk.html").read_bytes()


# ---- export ----------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("folder")
def test_scenes_and_robots_are_exported() -> None:
    words = ("random", "scene.xml", "--seed", 4, "--robot", "kneed", "--shank-mass", 0.4, "--initial", "rest")
    assert ran("export", *words) == "wrote scene.xml\n"
    assert mujoco.MjModel.from_xml_path("scene.xml").body("left_shank").mass[0] == 0.4
    assert "random (seed=4" in Path("scene.xml").read_text(encoding="utf-8")
    passive = mjbiped.walk(Unpowered(), mjbiped.Terrain.incline(2.0), steps=1)
    passive.save("passive.npz")
    ran("export", "passive.npz", "scene.xml")
    start = passive.samples["qpos"][0]
    assert mujoco.MjModel.from_xml_path("scene.xml").key("start").qpos == pytest.approx(start, abs=1e-15)
    ran("export", "robot.urdf", "--robot", "kneed", "--hip-mass", 3)
    assert Path("robot.urdf").read_text(encoding="utf-8") == urdf_of(mjbiped.KneedBiped(hip_mass=3.0))
    ran("export", "walk.npz", "robot.urdf")
    assert Path("robot.urdf").read_text(encoding="utf-8") == urdf_of(mjbiped.Compass())


@pytest.mark.parametrize("suffix", ["csv", "parquet", "mcap"])
@pytest.mark.usefixtures("folder")
def test_tables_of_a_record_and_of_a_walk(suffix: str) -> None:
    files = [Path(f"a.{suffix}"), *([] if suffix == "mcap" else [Path(f"a_touchdowns.{suffix}")])]
    wrote = "".join(f"wrote {file}\n" for file in files)
    assert ran("export", "walk.npz", files[0]) == wrote
    of_record = [each.read_bytes() for each in files]
    assert all(of_record)
    words = ("walk", "level", "--engine", "hybrid", "--steps", 2, "--initial-slope-estimate-deg", 3)
    assert ran(*words, "--out", files[0]).endswith(wrote)
    assert suffix == "mcap" or [each.read_bytes() for each in files] == of_record
