"""Study files: the walks that they ask for, and what is refused before anything walks."""

import math
import tomllib
from pathlib import Path

import own_controllers
import pytest
from documentation import ROOT, blocks

import mjbiped
from controllers import AdaptiveController
from mjbiped.errors import InputError
from mjbiped.studies.plan import MOST_CELLS, Study, plan, read_study


def planned(text: str, folder: Path = Path()) -> Study:
    return plan(folder / "study.toml", tomllib.loads(text))


def test_grid_in_order() -> None:
    study = planned("""
        engine = ["hybrid", "mujoco"]
        steps = 7
        controller.position_gain = { from = 2, to = 8, count = 3 }
        controller.replanning_delay = [0.5, "none"]
    """)
    assert study.varied == ("engine", "controller.position_gain", "controller.replanning_delay")
    assert [cell.index for cell in study.cells] == list(range(12))
    rows = [tuple(cell.values[name] for name in study.varied) for cell in study.cells]
    assert rows == [(e, g, d) for e in ("hybrid", "mujoco") for g in (2, 5, 8) for d in (0.5, "none")]
    assert study.cells[0].values["limit.steps"] == 7


def test_whole_grid_for_each_sample() -> None:
    text = """
        seed = 5
        samples = {samples}
        controller.position_gain = [2, 8]
        robot.hip_mass = {{ uniform = [5, 15] }}
        terrain.name = "random"
        terrain.seed = {{ integer = [0, 1000000] }}
        terrain.slope_deg = {{ plus_minus = {{ log_uniform = [0.1, 5] }} }}
    """
    study = planned(text.format(samples=4))
    assert study.drawn == {"robot.hip_mass", "terrain.seed", "terrain.slope_deg.plus_minus"} < {*study.varied}
    for first, second in zip(study.cells[::2], study.cells[1::2], strict=True):
        assert (first.robot(), first.terrain()) == (second.robot(), second.terrain())
    half = study.cells[0].values["terrain.slope_deg.plus_minus"]
    assert dict(study.cells[0].terrain().parameters)["slope_deg"] == (-float(half), float(half))
    assert len({cell.terrain() for cell in study.cells}) == 4
    more = planned(text.format(samples=6))
    assert more.cells[:8] == study.cells  # more samples leave the first ones as they are
    assert planned(text.format(samples=4)).digest == study.digest != more.digest


def test_alternatives_have_their_own_settings() -> None:
    study = planned("""
        controller = [{ name = "adaptive", position_gain = [4, 5] },
                      { name = ["passivity", "energy-constraint"], gain = 3 }]
        terrain = [{ name = "stairs", rise = -0.01 }, { name = ["level", "mixed"] }]
    """)
    names = ("controller.name", "controller.position_gain", "controller.gain", "terrain.name", "terrain.rise")
    assert study.varied == names
    assert len(study.cells) == 4 * 3
    assert study.cells[6].controller().describe()["gain"] == 3.0
    assert study.cells[1].terrain() == mjbiped.Terrain.level()


def test_settings_reach_the_walk() -> None:
    cells = planned("""
        robot = { hip_mass = 12, upper_length = 0.4 }
        model = { hip_mass = 9 }
        controller = { imitate_slope_deg = 1.5, initial_slope_estimate_deg = 1 }
        terrain = { name = "random", rise = ["-0.02..0", "0..0.01"], segment_length = { low = 1, high = 1.5 } }
    """).cells
    law = cells[0].controller()
    assert isinstance(law, AdaptiveController)
    assert cells[0].robot() == mjbiped.Compass(hip_mass=12, upper_length=0.4)
    assert law.robot == mjbiped.Compass(hip_mass=9, upper_length=0.4)
    assert (law.gait.slope, law.initial_slope_estimate) == (math.radians(1.5), math.radians(1.0))
    parameters = [dict(cell.terrain().parameters) for cell in cells]
    assert [each["rise"] for each in parameters] == [(-0.02, 0.0), (0.0, 0.01)]
    assert parameters[0]["segment_length"] == (1.0, 1.5)


def test_initial_states(controller: AdaptiveController) -> None:
    def initial(text: str) -> object:
        return planned(text).cells[0].initial(lambda: controller.gait.start.tolist())

    assert initial('initial = ["rest", "gait"]') == "rest"
    assert initial("initial = { q1 = -0.2, q2 = 0.2, dq1 = 1, dq2 = 0.5 }") == (-0.2, 0.2, 1.0, 0.5)
    q1, q2, dq1, dq2 = controller.gait.start.tolist()
    assert initial('initial = { around = "gait", dq1 = 0.01 }') == (q1, q2, dq1 + 0.01, dq2)


def test_file_is_looked_for_beside_the_study(tmp_path: Path) -> None:
    text = """terrain = [{ file = "trail.csv" }, { name = "level" },
                         { name = "recorded", file = "trail.csv", seed = [3, 8], length = 40 }]"""
    (tmp_path / "trail.csv").write_text("x,z\n0,0\n4,0.2\n30,-1\n")
    study = planned(text, tmp_path)
    recorded = [mjbiped.Terrain.recorded(tmp_path / "trail.csv", seed=seed, length=40) for seed in (3, 8)]
    assert study.cells[0].terrain() == mjbiped.Terrain.from_file(tmp_path / "trail.csv")
    assert [cell.terrain() for cell in study.cells[2:]] == recorded
    (tmp_path / "trail.csv").write_text("x,z\n0,0\n30,-2\n")
    assert planned(text, tmp_path).digest != study.digest


def test_the_scuffing_rule_can_vary() -> None:
    """A riser of 45 mm, 0.15 leg lengths ahead of a foothold, is met with a short reach and passed with a long one."""
    stairs = 'terrain = { name = "stairs", rise = 0.045, first = 0.532, count = 1, tread = 9 }'
    study = planned(f'steps = 3\nengine = "hybrid"\nscuffing.reach = [0.1, 0.2]\n{stairs}')
    assert [cell.row()["strikes"] for cell in study.cells] == [1, 0]


COUNT = "{ from = 1, to = 2, count = 1001 }"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("sead = 1", "unknown key 'sead'.*did you mean 'seed'"),
        ("samples = 3", "nothing is drawn"),
        ("robot = { hip_mass = { uniform = [5, 15] } }", "samples is missing"),
        ('engine = "hybrid"\ntimestep = 1e-4', "timestep: settings of the engine mujoco"),
        ('initial = { around = "gait", q3 = 1 }', "around, q1, q2, dq1, dq2"),
        ("controller = { position_gain = [5, -1] }", r"cell 1 \(controller.position_gain = -1\): position_gain = "),
        ('controller = { name = ["adaptive", "passive"], position_gain = 3 }', "name = 'passive'.*position_gain"),
        ('terrain = { name = "random", slope_deg = { low = 3 } }', "expected {low, high} or {plus_minus}"),
        (f"controller.position_gain = {COUNT}\nrobot.hip_mass = {COUNT}", f"at most {MOST_CELLS}"),
        ('plot = { parameters = ["robot.hip_mass"] }', "name in plot.parameters"),
        (f'plot = {{ measures = {["finished"] * 7} }}', "plot.measures must be a list of up to 6 names"),
        ('engine = "hybrid"\nrobot = { kind = ["compass", "kneed"] }\n'
         "initial = { q1 = 0, q2 = 0, dq1 = 0, dq2 = 0 }", "robot.kind = 'kneed'.*initial needs q3, dq3 as well"),
        ('engine = "hybrid"\nrobot = { kind = "kneed" }\nscuffing = { reach = 0.3 }', "its swing foot's contact is on"),
        ('terrain = { name = "incline", lateral_deg = [0, 2] }', r"cell 1 \(terrain.lateral_deg = 2\): .*Compass3D"),
    ],
)  # fmt: skip
def test_refused_in_words(text: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        planned(text)


def test_example_is_the_one_that_is_described(tmp_path: Path) -> None:
    path = ROOT / "scripts" / "studies" / "random_ground.toml"
    assert len(read_study(path).cells) == 1000
    described, own = [tomllib.loads(block.code) for block in blocks("docs/studies.md") if block.language == "toml"][:2]
    assert described == tomllib.loads(path.read_text(encoding="utf-8"))
    own_controllers.write(tmp_path, "spread.py", own_controllers.SPREAD)
    assert len(plan(tmp_path / "study.toml", own).cells) == 7
