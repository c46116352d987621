"""Studies of robots with knees: their names and parameters, first states, disturbances, measures and samples."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

import mjbiped
from controllers import KneedController
from mjbiped.errors import InputError
from mjbiped.records import measures
from mjbiped.studies.bins import measure_label, parameter_label
from mjbiped.studies.cell import KNEES_MEASURES, MEASURES
from mjbiped.studies.plan import Study, plan
from mjbiped.studies.run import run

HALVED = mjbiped.KneedBiped.halved_rods()


def planned(text: str) -> Study:
    return plan(Path("study.toml"), tomllib.loads(text))


@pytest.mark.slow
def test_a_robots_name_can_vary_with_its_parameters() -> None:
    """Inertias of rods follow the masses, as with a robot that is made so, and as the controller's wrong model does."""
    study = planned("""
        engine = "hybrid"
        robot = { kind = ["kneed", "halved-rods"], shank_mass = [0.5, 1.0] }
        model = { thigh_mass = 3.0 }
        """)
    assert study.varied == ("robot.kind", "robot.shank_mass")
    assert [cell.robot() for cell in study.cells] == [
        mjbiped.KneedBiped(shank_mass=0.5),
        mjbiped.KneedBiped(shank_mass=1.0),
        mjbiped.KneedBiped(2.5, 0.5, 0.0, thigh_centre=0.25, shank_centre=0.25),
        mjbiped.KneedBiped(2.5, 1.0, 0.0, thigh_centre=0.25, shank_centre=0.25),
    ]
    gait = mjbiped.find_reference(HALVED, clearance=0.08)
    law = study.cells[3].controller(gait)  # given, for one that nobody has looked for yet takes its time
    assert isinstance(law, KneedController)
    assert law.robot == mjbiped.KneedBiped(3.0, 1.0, 0.0, thigh_centre=0.25, shank_centre=0.25)
    assert (study.measures, planned("").measures) == (KNEES_MEASURES, MEASURES)
    assert parameter_label("robot.thigh_centre") == "robot thigh centre (m)"
    assert measure_label("peak_knee_torque_Nm") == "peak torque, swing knee (N m)"
    assert measure_label("foot_length_99_percent_m") == "foot that holds it 99 % of the time, length (m)"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('robot = { kind = "kneeed" }', "unknown robot 'kneeed'.*did you mean 'kneed'"),
        ('robot = { kind = "kneed", leg_mass = 3 }', "parameter of the robot kneed 'leg_mass'.*thigh_mass"),
        ('robot = { kind = ["compass", "kneed"], leg_mass = 3 }', "robot.kind = 'kneed'.*leg_mass"),
        (
            'robot = { kind = ["compass", "kneed"] }\ninitial = { q1 = 0, q2 = 0, dq1 = 0, dq2 = 0 }',
            "robot.kind = 'kneed'.*initial needs q3, dq3 as well",
        ),
        ('robot = { kind = "kneed" }\nscuffing = { reach = 0.3 }', "its swing foot's contact is on"),
        (
            'robot = { kind = ["compass", "kneed"] }\ncontroller = { knee_bump = 0.3 }',
            "robot.kind = 'compass'.*unknown setting.*'knee_bump'",
        ),
    ],
)  # fmt: skip
def test_what_no_robot_can_do_is_refused_before_anything_walks(text: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        planned(text if "engine" in text else f'engine = "hybrid"\n{text}')


@pytest.mark.slow
@pytest.mark.usefixtures("studies_in_threads")
def test_rows_are_what_the_walks_give(tmp_path: Path) -> None:
    study = planned("""
        engine = "hybrid"
        steps = 3
        robot = { kind = ["compass", "halved-rods"] }
        initial = { around = "gait", dq1 = 0.01 }
        disturbances = { control_period = 0.002 }
        terrain = { name = "stairs", rise = 0.02 }
        """)
    rows, *_ = run(study, tmp_path, workers=1, trajectories=True)
    for row, cell in zip(rows, study.cells, strict=True):
        law, disturbances = cell.controller(), mjbiped.Disturbances(control_period=0.002)
        assert law.gait is not None
        start = law.gait.start.copy()
        start[len(start) // 2] += 0.01
        settings = {"engine": "hybrid", "steps": 3, "initial": start.tolist(), "disturbances": disturbances}
        summary = measures.summary(mjbiped.walk(law, mjbiped.Terrain.stairs(rise=0.02), **settings))
        known = [name for name in KNEES_MEASURES if name in summary]
        assert [row[name] for name in known] == [summary[name] for name in known]  # bit by bit
    assert (rows[0]["peak_knee_torque_Nm"], rows[1]["peak_knee_torque_Nm"] > 1.0) == (None, True)
    samples = pytest.importorskip("pandas").read_parquet(tmp_path / "trajectories.parquet")
    assert samples.attrs["units"]["q_shank"] == "rad"
    shanks = samples.groupby("cell")["q_shank"].count()
    assert (shanks[0], shanks[1] > 100) == (0, True)
