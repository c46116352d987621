"""Robustness studies: what their files ask for, what is refused, and what is found of rows."""

import json
import math
import pickle
from pathlib import Path
from typing import Any

import golden_numbers
import numpy as np
import pytest
from command_line import run
from golden_states import numbers_in
from hypothesis import given
from hypothesis import strategies as st
from legible import assert_legible

import mjbiped
from mjbiped import Compass, InputError, KneedBiped, Survival
from mjbiped.limit_cycles.basin import Fate, basin_of_control, rates_around
from mjbiped.plotting import WIDTHS, figure_width
from mjbiped.studies import robustness_report as report
from mjbiped.studies import robustness_walks
from mjbiped.studies.cell import Cell
from mjbiped.studies.robustness import Plan, plan
from mjbiped.studies.robustness_findings import Robustness, greatest_survived
from mjbiped.studies.robustness_walks import BASIN, BASIN_RATES, DISTURBANCES, LEVEL, MARGINS, SURVIVAL, Values

SMALL: dict[str, Any] = {
    "engine": ["hybrid", "mujoco"],
    "steps": 50,
    "seeds": 3,
    "grounds": ["treads:deviation=0.02,slope_deg=-2..2", "waves"],
    "limits": {"step up": [0.01, 0.02], "phases": 4, "torque": 50},
    "scuffing": {"reach": 0.15},
    "controller": [{"label": "paper"}, {"label": "free", "name": "passivity"}],
}
KNEES: dict[str, Any] = {
    "steps": 20,
    "seeds": 2,
    "grounds": ["treads:deviation=0.01"],
    "limits": {"step down": [0.02, 0.04], "phases": 2, "basin": 2, "torque": 40},
    "robot": {"kind": "kneed"},
    "controller": [{"label": "knees", "reference": "clearance=0.08"}, {"label": "straight", "robot": {}}],
}


def planned(content: dict[str, Any], folder: Path = Path()) -> Plan:
    return plan(folder / "x.toml", content)


def kinds_of(content: dict[str, Any]) -> list[object]:
    return [cell.values["test"] for cell in planned(content).study.cells]


def of(cells: tuple[Cell, ...], **values: object) -> list[Cell]:
    return [cell for cell in cells if all(cell.values.get(name) == value for name, value in values.items())]


def test_the_walks_of_a_study(gait: mjbiped.PassiveGait) -> None:
    cells, tests = planned(SMALL).study.cells, kinds_of(SMALL)
    assert {test: tests.count(test) for test in tests} == {LEVEL: 4, "step up": 32, SURVIVAL: 24}
    assert all(cell.section("scuffing") == {"reach": 0.15, "delay": 0.1} for cell in cells)
    golden_numbers.check("walks of a study", {"all": numbers_in([dict(cell.values) for cell in cells])})
    paired = [cell.terrain() for cell in of(cells, ground="waves", case=2)]
    assert (len(paired), len(set(paired))) == (4, 1)  # all controllers and engines on the same ground
    assert paired[0].x[-1] > 50 * 0.5  # as long as any walk
    mine = of(cells, test="step up", controller="paper", engine="hybrid", magnitude=0.01)
    places = [float(cell.values["terrain.first"]) for cell in mine]
    assert np.divide(places, gait.step_length) == pytest.approx(3.0 + (np.arange(4) + 0.5) / 4)


def test_all_margins_can_be_walked_and_a_controller_may_have_weak_motors() -> None:
    """Values are checked as a walk would check them."""
    content = {"engine": ["hybrid", "mujoco"], "seeds": 1, "limits": {"basin": False}, "margins": {}}
    cells = planned(content).study.cells
    for name, margin in MARGINS.items():
        assert [cell.values["magnitude"] for cell in of(cells, test=name)] == [*margin.magnitudes] * 2
    content = {**SMALL, "controller": [{"label": "any"}, {"label": "weak", "torque_limit": 50}]}
    cells = planned(content | {"margins": {"torque limit": [20]}}).study.cells
    limits = {(c.values["controller"], c.values["test"]): c.section("disturbances").get("torque_limit") for c in cells}
    assert (limits["weak", LEVEL], limits["weak", "step up"], limits["any", LEVEL]) == (50.0, 50.0, None)
    assert limits["weak", "torque limit"] == limits["any", "torque limit"] == 20.0


def test_unless_a_file_says_otherwise_all_disturbances_are_tried() -> None:
    once = {"seeds": 1, "limits": {"phases": 1}}
    for limits, tried, basin in (
        ({}, {*DISTURBANCES}, BASIN_RATES),
        ({"slope up": True}, {"slope up"}, 0),
        ({"slope up": False}, set(), 0),
        ({"step up": True, "basin": 4}, {"step up"}, 4),
    ):
        found = planned({**once, "limits": {"phases": 1, **limits}}).limits
        assert ({*found.magnitudes}, found.basin) == (tried, basin)
    assert kinds_of({"grounds": [], "limits": {"step up": False, "basin": False}}) == [LEVEL]
    assert kinds_of({"seeds": 2, "grounds": ["treads"]}) == [LEVEL, SURVIVAL, SURVIVAL]


def test_a_basin_is_that_of_its_own_module(gait: mjbiped.PassiveGait, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robustness_walks, "BASIN_WIDTH", 1.0)  # from all of the wide one this controller falls
    limits = {"step up": False, "basin": 6, "steps_after": 8}
    cells = of(planned({"seeds": 1, "limits": limits, "controller": [{"name": "passivity"}]}).study.cells, test=BASIN)
    stance, swing = rates_around(gait.start, 6)
    basin = basin_of_control(cells[0].controller(), stance_rates=stance, swing_rates=swing, limit=8)
    rows = [cell.row() for cell in cells]
    finished = np.array([row["outcome"] == "finished" for row in rows]).reshape(6, 6).T
    assert 0 < finished.sum() < finished.size
    np.testing.assert_array_equal(finished, (basin.fates == Fate.SETTLED) | (basin.fates == Fate.UNDECIDED))


def test_with_knees_phases_are_of_their_step_and_first_swing_legs_are_straight() -> None:
    wanted = planned(KNEES)
    mine = of(wanted.study.cells, controller="knees", test="step down", magnitude=0.02)
    gait = mjbiped.find_reference(KneedBiped(), clearance=0.08)
    assert [float(c.values["terrain.first"]) / gait.step_length for c in mine] == pytest.approx([3.25, 3.75])
    basin = of(wanted.study.cells, controller="knees", test=BASIN)
    starts = np.array([cell.initial(lambda: gait.start.tolist()) for cell in basin], dtype=float)
    assert starts.shape == (4, 6)
    np.testing.assert_array_equal(starts[:, 1], starts[:, 2])
    np.testing.assert_allclose(starts[:, 4], starts[:, 5], atol=1e-15)
    assert np.ptp(starts[:, 4]) > 1.0


def test_seeds_walk_on_stretches_of_a_record_beside_the_file(tmp_path: Path) -> None:
    (tmp_path / "trail.csv").write_text("x,z\n0,0\n3,0.1\n7,-0.1\n9,0\n")
    content = {"grounds": ["recorded:file=trail.csv"], "seeds": 3, "steps": 20, "limits": {"step up": False}}
    wanted = planned(content, tmp_path)
    cells = pickle.loads(pickle.dumps(of(wanted.study.cells, test=SURVIVAL)))  # as a worker gets them
    expected = [mjbiped.Terrain.recorded(tmp_path / "trail.csv", seed=seed, length=14.0) for seed in range(3)]
    assert [cell.terrain() for cell in cells] == expected


# one walk on level ground, the phases, four first rates, and two seeds on one ground and with one delay
BASINS = {"phases": 999_995, "step up": [0.1], "basin": 2}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({"grounds": ["stairs"]}, "unknown random ground 'stairs'"),
        ({"limits": {"step up": [0.02, 0.01]}}, "magnitudes must ascend"),
        ({"margins": {"torque limit": [10, 20]}}, "margins.torque limit: magnitudes must descend"),
        ({"seeds": 2, "limits": BASINS, "margins": {"delay": [0.1]}}, "these are 1000004 walks"),
        ({"controller": [{}, {}]}, "controller 2: label = 'adaptive': must be a text of its own"),
        ({"controller": [{"position_gain": [2.0, 3.0]}]}, "give each variant a"),
        ({"robot": {"kind": "kneed"}, "scuffing": {"reach": 0.3}}, "scuffing is for straight legs"),
        ({"controller": [{"robot": {"kind": "kneed"}, "name": "passivity"}]}, "choose a controller for that robot"),
    ],
)
def test_what_no_study_can_have_is_refused(content: dict[str, Any], message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=message):
        planned(content, tmp_path)


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=20), st.floats(0.5, 1.0))
def test_nothing_below_the_greatest_is_not_survived(shares: list[float], wanted: float) -> None:
    cases = 100
    survived = {float(k): [case < round(share * cases) for case in range(cases)] for k, share in enumerate(shares, 1)}
    greatest = int(greatest_survived(DISTURBANCES["step up"], survived, wanted) or 0)
    found = [sum(each) / cases for each in survived.values()]
    assert all(share >= wanted for share in found[:greatest])
    assert greatest == len(shares) or found[greatest] < wanted


@pytest.mark.parametrize(
    ("name", "rise", "slope_deg"),
    [("step up", 0.04, 0.0), ("step down", -0.1, 0.0), ("slope down", 0.0, 3.0), ("slope up", 0.0, -3.0)],
)
def test_level_ground_is_disturbed_once_and_where_it_is_said(name: str, rise: float, slope_deg: float) -> None:
    values = DISTURBANCES[name].described(abs(rise or slope_deg), "hybrid", Compass(), 1.5)
    expected = mjbiped.Terrain.from_segments([(1.5, 0.0), (9.0, slope_deg, rise)])
    places = np.array([-1.0, 1.4999, 1.5, 9.0])
    np.testing.assert_allclose(Cell(0, None, values).terrain().height(places), expected.height(places), atol=1e-9)


SHORT = dict.fromkeys(("thigh_length", "shank_length", "thigh_centre", "shank_centre"), 0.8)
RODS = KneedBiped(hip_mass=4.0)


@pytest.mark.parametrize(
    ("name", "robot", "factors"),
    [
        ("mass too great", Compass(), {"leg_mass": 1.2, "leg_inertia": 1.2}),  # heavier legs of the same shape
        ("inertia too great", Compass(), {"leg_inertia": 1.2}),
        # uniform rods of the same shape; the point mass at the hip is none of the legs'
        ("mass too great", RODS, dict.fromkeys(("thigh_mass", "shank_mass", "thigh_inertia", "shank_inertia"), 1.2)),
        ("legs too short", RODS, SHORT | dict.fromkeys(("thigh_inertia", "shank_inertia"), 0.64)),
    ],
)
def test_what_a_controller_believes_wrongly(name: str, robot: Compass | KneedBiped, factors: dict[str, float]) -> None:
    kind: Values = {"robot.kind": robot.kind, "robot.hip_mass": robot.hip_mass, "controller.name": "adaptive"}
    cell = Cell(0, None, {**kind, **MARGINS[name].described(20.0, "hybrid", robot)})
    gait = mjbiped.find_kneed_gait(KneedBiped(), math.radians(2.5)) if robot is RODS else None
    assert cell.robot() == robot
    believed = cell.controller(gait).robot
    for parameter in type(robot).numbers():
        wanted = factors.get(parameter, 1.0) * getattr(robot, parameter)
        assert getattr(believed, parameter) == pytest.approx(wanted, rel=1e-12)


def test_friction_is_set_in_mujoco_and_asked_for_in_the_hybrid_engine() -> None:
    friction = MARGINS["friction"]
    assert friction.described(0.5, "mujoco", Compass()) == {"disturbances.friction": 0.5}
    assert friction.described(0.5, "hybrid", Compass()) == {}
    for engine, asked, borne in (("hybrid", 0.49, True), ("hybrid", 0.51, False), ("mujoco", 0.51, True)):
        assert friction.borne({"engine": engine, "magnitude": 0.5, "largest_stance_friction": asked}) is borne
    # without bound: the ground would have to pull
    assert not friction.borne({"engine": "hybrid", "magnitude": 0.5, "largest_stance_friction": None})


def row(test: str, controller: str, steps: int, outcome: str, **values: Any) -> dict[str, Any]:
    blank = dict.fromkeys(("ground", "magnitude", "case", "error"))
    usual = {
        "engine": "hybrid", "peak_ankle_torque_Nm": 1.0, "peak_hip_torque_Nm": 1.0, "cost_of_transport": 0.03,
        "distance_m": 0.4 * steps, "mean_step_length_m": 0.4, "foot_length_99_percent_m": 0.05, "speed_m_per_s": 0.5,
        "steps_violating_contact": 0,
    }  # fmt: skip
    return {"test": test, "controller": controller, "steps": steps, "outcome": outcome, **blank, **usual, **values}


WANTED = planned(
    {
        "steps": 100,
        "seeds": 2,
        "grounds": ["treads"],
        "limits": {"step up": [0.02, 0.04], "step down": [0.1], "phases": 2, "torque": 10.0, "basin": 2},
        "controller": [{"label": "one"}, {"label": "two"}],
    }
)


@pytest.fixture(scope="module")
def result() -> Robustness:
    rows = []
    for controller, steps, peak in (("one", 20, 5.0), ("two", 100, 60.0)):
        rows.append(row(LEVEL, controller, 40, "finished", cost_of_transport=0.035))
        for case in (0, 1):
            outcome = "finished" if steps == 100 and case else "fell"
            rows.append(row(SURVIVAL, controller, steps, outcome, ground="treads", case=case))
            rows.append(row("step up", controller, 24, "finished", magnitude=0.02, case=case))
            outcome = "fell" if case and steps < 100 else "finished"  # the other in spite of a pull on the ground
            pulls = {"steps_violating_contact": steps // 100}
            rows.append(row("step up", controller, 6, outcome, magnitude=0.04, case=case, **pulls))
            rows.append(row("step down", controller, 24, "finished", magnitude=0.1, case=case, peak_hip_torque_Nm=peak))
        rows += [row(BASIN, controller, 20, "fell" if case == 2 else "finished", case=case) for case in range(4)]
    rows.append(row(SURVIVAL, "two", 0, "failed", ground="treads", case=1, error="no gait"))
    return Robustness(WANTED, rows)


def test_findings_of_rows(result: Robustness, gait: mjbiped.PassiveGait) -> None:
    one, two = result.of("hybrid")
    assert result.survival("hybrid", "one", "treads") == Survival((20, 20), (True, True))
    # 2 m of level ground are five steps of 0.4 m; five more are to forget them
    assert [each["survival"]["treads"]["mean_steps_to_fall"] for each in (one, two)] == [10.0, 180.0]
    assert two["survival"]["treads"]["ratio_to_first"][0] == pytest.approx(18.0)
    assert one["survival"]["treads"]["cost_of_transport"] == pytest.approx(0.03, rel=1e-12)
    up, down = (one["greatest_survived"][test] for test in ("step up", "step down"))
    assert (up["magnitude"], up["with_contact_violated"], up["unit"]) == (0.02, 0.02, "m")
    assert (up["foot_length_99_percent_m"], up["beyond_what_was_tried"]) == (0.05, False)
    assert (down["magnitude"], down["beyond_what_was_tried"]) == (0.1, True)
    assert two["greatest_survived"]["step down"]["magnitude"] is None  # beyond the torque that is allowed
    up = two["greatest_survived"]["step up"]
    assert (up["magnitude"], up["with_contact_violated"]) == (0.02, 0.04)
    assert (one["errors"], two["errors"]) == ([], ["no gait"])
    window = (
        3.3 * gait.start[2] * 13.2 * max(abs(gait.start[2:]))
    )  # three times as wide as that of `mjbiped basin`, either way
    assert one["basin"] == {"share": 0.75, "area_rad2_per_s2": pytest.approx(0.75 * window)}
    golden_numbers.check("findings", {"all": numbers_in(result.summary())})


def test_tables_put_controllers_side_by_side(result: Robustness, tmp_path: Path) -> None:
    tables = report.robustness_tables(result)
    (headings, level), _, (_, random) = map(report.texts_of, tables)
    assert headings[:4] == ["controller", "c_mt, level", "speed (m/s)", "sole (m)"]
    assert headings[4:] == ["step up (m)", "step down (m)", "basin (rad²/s²)"]
    assert level[0][:-1] == ["one", "0.0350", "0.500", "0.05", "0.02", ">= 0.1"]
    assert level[1][-2] == "< 0.1"
    # 20 steps of 22 tries, 180 of 181
    assert [(row[4].split(" ")[0], row[5]) for row in random] == [("10", "0.90909"), ("180", "0.99448")]
    assert "| one | 0.0300 | 0.05 | 2 | 10 (" in report.write_tables(result, tmp_path / "robustness.md").read_text()


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("plot", [report.plot_survival, report.plot_limits])
def test_pictures_are_legible(result: Robustness, plot: Any, width: str) -> None:
    with figure_width(width):
        figure = plot(result, "hybrid")
        assert_legible(figure, width)
        assert figure.get_figheight() < 9.0  # inches: two panels, one above the other at most


STUDY = """
seeds = 2
steps = 60
grounds = ["treads:deviation=0.04"]
limits = { "step up" = [0.02, 0.15], phases = 2, steps_after = 4 }
controller = [{ label = "paper" }, { label = "gentle", position_gain = 2 }]
"""


@pytest.mark.usefixtures("studies_in_threads")
def test_the_command_tells_the_number_of_walks_walks_goes_on_and_writes(tmp_path: Path) -> None:
    study, out = tmp_path / "study.toml", tmp_path / "out"
    study.write_text(STUDY)

    def told(*words: str) -> str:
        done = run("robustness", study, "--out", out, "--workers", 1, *words)
        assert done.exit_code == 0
        return done.stdout

    assert told("--dry-run").startswith("14 walks: about ")
    assert [*tmp_path.iterdir()] == [study]
    printed = json.loads(told("--json"))
    table = (out / "study.csv").read_bytes()
    assert table.count(b"\n") == 1 + 2 * (1 + 2 * 2 + 2)
    written = sorted(file.name for file in out.iterdir() if file.suffix in (".png", ".csv", ".md"))
    assert written == ["limits.png", "robustness.md", "study.csv", "survival.png"]
    paper, gentle = printed["controllers"]
    assert paper["level"]["cost_of_transport"] == pytest.approx(0.0349, abs=1e-4)
    assert paper["greatest_survived"]["step up"]["magnitude"] == 0.02  # clears 46 mm, of docs/gaits.md
    assert gentle["survival"]["treads:deviation=0.04"]["walks"] == 2
    assert json.loads(told("--json")) == printed  # all rows were there
