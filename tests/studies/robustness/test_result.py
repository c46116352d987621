"""Findings of rows, their tables and pictures; a study walked to its end, broken off and gone on with."""

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from legible import assert_legible

from mjbiped.analysis.survival import Survival
from mjbiped.cli.main import main
from mjbiped.gaits.passive import find_passive_gait
from mjbiped.plotting import WIDTHS, figure_width
from mjbiped.robots.compass import Compass
from mjbiped.studies.robustness import Plan, plan
from mjbiped.studies.robustness_findings import Robustness
from mjbiped.studies.robustness_report import plot_limits, plot_survival, robustness_tables, texts_of, write_tables
from mjbiped.studies.robustness_walks import BASIN, LEVEL, SURVIVAL

CONTENT: dict[str, Any] = {
    "steps": 100,
    "seeds": 2,
    "grounds": ["treads"],
    "limits": {"step up": [0.02, 0.04], "step down": [0.1], "phases": 2, "torque": 10.0, "basin": 2},
    "controller": [{"label": "one"}, {"label": "two"}],
}
STUDY = """
seeds = 2
steps = 60
grounds = ["treads:deviation=0.04"]
[limits]
"step up" = [0.02, 0.15]
phases = 2
steps_after = 4
[[controller]]
label = "paper"
[[controller]]
label = "gentle"
position_gain = 2
"""


def row(test: str, controller: str, steps: int, outcome: str, **values: Any) -> dict[str, Any]:
    blank = dict.fromkeys(("ground", "magnitude", "case", "error"))
    usual = {
        "engine": "hybrid", "peak_ankle_torque_Nm": 1.0, "peak_hip_torque_Nm": 1.0, "cost_of_transport": 0.03,
        "distance_m": 0.4 * steps, "mean_step_length_m": 0.4, "foot_length_99_percent_m": 0.05, "speed_m_per_s": 0.5,
        "steps_violating_contact": 0,
    }  # fmt: skip
    return {"test": test, "controller": controller, "steps": steps, "outcome": outcome, **blank, **usual, **values}


@pytest.fixture(scope="module")
def wanted() -> Plan:
    return plan(Path("x.toml"), CONTENT)


@pytest.fixture(scope="module")
def result(wanted: Plan) -> Robustness:
    rows = []
    for controller, steps in (("one", 20), ("two", 100)):
        rows.append(row(LEVEL, controller, 40, "finished", cost_of_transport=0.035))
        for case in (0, 1):
            outcome = "finished" if steps == 100 and case else "fell"
            rows.append(row(SURVIVAL, controller, steps, outcome, ground="treads", case=case))
            rows.append(row("step up", controller, 24, "finished", magnitude=0.02, case=case))
            rows.append(row("step up", controller, 6, "fell" if case else "finished", magnitude=0.04, case=case))
            peak = 60.0 if controller == "two" else 5.0
            rows.append(row("step down", controller, 24, "finished", magnitude=0.1, case=case, peak_hip_torque_Nm=peak))
        rows += [row(BASIN, controller, 20, "fell" if case == 2 else "finished", case=case) for case in range(4)]
    rows.append(row(SURVIVAL, "two", 0, "failed", ground="treads", case=1, error="no gait"))
    return Robustness(wanted, rows)


def test_findings_of_rows(result: Robustness) -> None:
    one, two = result.of("hybrid")
    assert result.survival("hybrid", "one", "treads") == Survival((20, 20), (True, True))
    # 2 m of level ground are five steps of 0.4 m; five more are to forget them
    assert [each["survival"]["treads"]["mean_steps_to_fall"] for each in (one, two)] == [10.0, 180.0]
    assert two["survival"]["treads"]["ratio_to_first"][0] == pytest.approx(18.0)
    assert one["survival"]["treads"]["cost_of_transport"] == pytest.approx(0.03, rel=1e-12)
    assert one["greatest_survived"]["step up"] == {
        "magnitude": 0.02,
        "foot_length_99_percent_m": 0.05,
        "with_contact_violated": 0.02,
        "unit": "m",
        "beyond_what_was_tried": False,
    }
    assert one["greatest_survived"]["step down"]["magnitude"] == 0.1
    assert one["greatest_survived"]["step down"]["beyond_what_was_tried"]
    assert two["greatest_survived"]["step down"]["magnitude"] is None  # beyond the torque that is allowed
    assert (one["errors"], two["errors"]) == ([], ["no gait"])
    start = find_passive_gait(Compass(), math.radians(2)).start
    window = 3.3 * start[2] * 13.2 * max(abs(start[2:]))  # three times as wide as that of `mjbiped basin`, either way
    assert one["basin"] == {"share": 0.75, "area_rad2_per_s2": pytest.approx(0.75 * window)}
    assert result.summary()["scuffing"] == {"reach_leg_lengths": 0.2, "delay_s": 0.1}


def test_ground_that_no_foot_has_is_told_apart(wanted: Plan) -> None:
    rows = [row("step down", "one", 24, "finished", magnitude=0.1, case=0, steps_violating_contact=1)]
    findings, _ = Robustness(wanted, rows).findings
    assert findings["greatest_survived"]["step down"]["magnitude"] is None
    assert findings["greatest_survived"]["step down"]["with_contact_violated"] == 0.1
    headings, cells = texts_of(robustness_tables(Robustness(wanted, rows))[0])
    assert cells[0][headings.index("step down (m)")] == "< 0.1 (>= 0.1)"


def test_a_walk_that_an_error_ends_is_not_survived(wanted: Plan) -> None:
    blank = dict.fromkeys(("peak_ankle_torque_Nm", "peak_hip_torque_Nm", "steps_violating_contact"))
    rows = [row("step up", "one", 24, "finished", magnitude=0.02, case=0)]
    rows.append(row("step up", "one", 0, "failed", magnitude=0.04, case=0, error="never lands", **blank))
    one = Robustness(wanted, rows).of("hybrid")[0]
    assert one["greatest_survived"]["step up"]["magnitude"] == 0.02
    assert one["errors"] == ["never lands"]


def test_tables_put_controllers_side_by_side(result: Robustness, tmp_path: Path) -> None:
    tables = robustness_tables(result)
    (headings, level), (_, soles), (_, random) = map(texts_of, tables)
    assert headings[:4] == ["controller", "c_mt, level", "speed (m/s)", "sole (m)"]
    assert headings[4:] == ["step up (m)", "step down (m)", "basin (rad²/s²)"]
    assert level[0][:-1] == ["one", "0.0350", "0.500", "0.05", "0.02", ">= 0.1"]
    assert level[1][-2] == "< 0.1"
    assert "survive; basin of 2² first rates of the legs, within 10 N m" in str(tables[0].caption)
    assert soles == [["one", "0.05", "0.05"], ["two", "0.05", "-"]]
    assert [row[:4] for row in random] == [["one", "0.0300", "0.05", "2"], ["two", "0.0300", "0.05", "1"]]
    assert [row[4].split(" ")[0] for row in random] == ["10", "180"]
    # 20 steps of 22 tries, 180 of 181
    assert [row[5] for row in random] == ["0.90909", "0.99448"]
    assert random[0][7:] == ["0 %", ""]
    assert random[1][8].startswith("18 (")
    assert all("scuffing rule" in str(table.caption) for table in tables)
    text = write_tables(result, tmp_path / "robustness.md").read_text()
    assert "| one | 0.0300 | 0.05 | 2 | 10 (" in text


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("plot", [plot_survival, plot_limits])
def test_pictures_are_legible(result: Robustness, plot: Any, width: str) -> None:
    with figure_width(width):
        assert_legible(plot(result, "hybrid"), width)


def test_pictures_of_a_controller_that_never_fell(wanted: Plan) -> None:
    rows = [
        row(SURVIVAL, name, 100, "finished", ground="treads", case=case) for name in ("one", "two") for case in (0, 1)
    ]
    result = Robustness(replace(wanted, limits=replace(wanted.limits, magnitudes={})), rows)
    plot_survival(result, "hybrid")
    _, cells = texts_of(robustness_tables(result)[1])
    assert [row[3:5] for row in cells] == [["0", "no fall (> 51.5)"]] * 2  # 190 steps / -ln 0.025


@pytest.mark.usefixtures("studies_in_threads")
def test_a_dry_run_tells_the_number_of_walks_and_leaves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study = tmp_path / "study.toml"
    study.write_text(STUDY)
    with pytest.raises(SystemExit):
        main(["robustness", str(study), "--dry-run", "--workers", "1"])
    told = capsys.readouterr().out
    assert told.startswith("14 walks: about ")
    assert "inferred from 5 of them" in " ".join(told.split())
    assert [*tmp_path.iterdir()] == [study]


@pytest.mark.slow
def test_the_command_walks_goes_on_and_writes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    study, out = tmp_path / "study.toml", tmp_path / "out"
    study.write_text(STUDY)

    def run() -> dict[str, Any]:
        with pytest.raises(SystemExit) as ended:
            main(["robustness", str(study), "--out", str(out), "--workers", "1", "--json"])
        assert ended.value.code in (0, None)
        printed: dict[str, Any] = json.loads(capsys.readouterr().out)
        return printed

    printed = run()
    table = (out / "study.csv").read_bytes()
    assert table.count(b"\n") == 1 + 2 * (1 + 2 * 2 + 2)
    written = sorted(file.name for file in out.iterdir() if file.suffix in (".png", ".csv", ".md"))
    assert written == ["limits.png", "robustness.md", "study.csv", "survival.png"]
    paper, gentle = printed["controllers"]
    assert paper["level"]["cost_of_transport"] == pytest.approx(0.0349, abs=1e-4)
    assert paper["greatest_survived"]["step up"]["magnitude"] == 0.02  # clears 46 mm, of docs/gaits.md
    assert gentle["survival"]["treads:deviation=0.04"]["walks"] == 2
    assert run() == printed  # all rows were there
    assert (out / "study.csv").read_bytes() == table
