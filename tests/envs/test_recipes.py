"""Robot, terrain and disturbances of episodes: objects, names, tables, and what is drawn for each episode."""

import copy
from typing import Any

import numpy as np
import pytest

import mjbiped
from mjbiped.envs import Curriculum
from mjbiped.envs.single import WalkEnv
from mjbiped.envs.tasks import Episode, WalkTask
from mjbiped.envs.vector import WalkVectorEnv
from mjbiped.errors import InputError
from mjbiped.rules.termination import Outcome

DRAWN: dict[str, Any] = {
    "robot": {"leg_mass": {"uniform": [4.5, 5.5]}, "sole": [{"uniform": [0.05, 0.1]}, 0.15]},
    "terrain": {"name": "stairs", "rise": {"uniform": (-0.03, 0.0)}, "count": {"integer": [1, 9]}},
    "disturbances": {"friction": {"log_uniform": [0.5, 2.0]}, "rate_noise": {"normal": [0.05, 0.01]}},
}


def drawn_by(task: WalkTask, seed: int = 0) -> Episode:
    return task.episode(np.random.default_rng(seed))


def test_objects_names_and_tables_say_the_same() -> None:
    kneed = mjbiped.KneedBiped()
    given: tuple[Any, ...] = (kneed, "kneed", {"kind": "kneed"}, {"kind": "kneed", "thigh_mass": 4.5})
    for robot in given:
        assert drawn_by(WalkTask("walk_level", robot=robot)).robot == kneed
    assert drawn_by(WalkTask("walk_level", robot={"sole": (0.05, 0.15)})).robot == mjbiped.Compass(sole=(0.05, 0.15))
    stairs = mjbiped.Terrain.stairs(rise=0.01)
    for terrain in (stairs, {"name": "stairs", "rise": 0.01}):
        assert drawn_by(WalkTask("walk_level", terrain=terrain)).terrain == stairs
    assert drawn_by(WalkTask("walk_stairs", terrain={"rise": 0.01})).terrain == stairs
    assert drawn_by(WalkTask("walk_level", terrain="mixed")).terrain == mjbiped.Terrain.mixed()
    weak = mjbiped.Disturbances(torque_limit=20.0, seed=3)
    for disturbances in (weak, {"torque_limit": 20.0, "seed": 3}):
        assert drawn_by(WalkTask("walk_level", disturbances=disturbances)).disturbances == weak
    assert drawn_by(WalkTask("walk_level")).disturbances == mjbiped.Disturbances()


def test_an_episode_is_made_of_what_was_drawn() -> None:
    task = WalkTask("walk_level", **DRAWN)
    episode = drawn_by(task)
    assert list(episode.drawn) == [
        "disturbances.friction",
        "disturbances.rate_noise",
        "disturbances.seed",
        "robot.leg_mass",
        "robot.sole.0",
        "terrain.count",
        "terrain.rise",
    ]
    assert episode.robot == mjbiped.Compass(
        leg_mass=episode.drawn["robot.leg_mass"], sole=(episode.drawn["robot.sole.0"], 0.15)
    )
    assert dict(episode.terrain.parameters)["rise"] == episode.drawn["terrain.rise"]
    assert dict(episode.terrain.parameters)["count"] == episode.drawn["terrain.count"]
    assert episode.disturbances.to_dict() == {
        key.removeprefix("disturbances."): value for key, value in episode.drawn.items() if key.startswith("dist")
    }
    assert drawn_by(task) == episode
    assert drawn_by(task, 1).drawn != episode.drawn


def test_the_order_of_a_table_does_not_matter() -> None:
    def turned(table: dict[str, Any]) -> dict[str, Any]:
        return dict(reversed(table.items()))

    other: Any = {name: turned(table) for name, table in reversed(DRAWN.items())}
    assert drawn_by(WalkTask("walk_level", **other)) == drawn_by(WalkTask("walk_level", **DRAWN))


def test_what_is_drawn_stays_within_its_ends() -> None:
    task, random = WalkTask("walk_level", **DRAWN), np.random.default_rng(0)
    values = [task.episode(random).drawn for _ in range(300)]
    mass = np.array([each["robot.leg_mass"] for each in values])
    assert 4.5 <= mass.min() < 4.52  # of 300 the least is more than 0.02 off once in 400 tries: 0.98^300
    assert 5.48 < mass.max() <= 5.5
    assert {each["terrain.count"] for each in values} == set(range(1, 10))


def test_seeds_are_drawn_unless_given() -> None:
    assert "terrain.seed" in drawn_by(WalkTask("walk_level", terrain="waves")).drawn
    assert "disturbances.seed" in drawn_by(WalkTask("walk_level", disturbances={"angle_noise": 0.01})).drawn
    fixed = WalkTask("walk_random", terrain={"seed": 4}, disturbances={"angle_noise": 0.01, "seed": 0})
    assert drawn_by(fixed).drawn == {}
    assert drawn_by(fixed, 1).terrain is drawn_by(fixed, 2).terrain


def test_the_controller_knows_the_medians() -> None:
    task = WalkTask("walk_level", residual=True, robot={"leg_mass": {"uniform": [4.0, 8.0]}, "hip_mass": 1.0})
    assert task.model == mjbiped.Compass(leg_mass=6.0, hip_mass=1.0)
    assert task.controller.inner.robot is task.model
    assert task.gait == mjbiped.find_passive_gait(task.model, np.radians(2.0))
    assert task.peak[0] == pytest.approx(35.55 * 1.3)  # 13 kg beside 10


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"robot": "kned"}, "did you mean 'kneed'"),
        ({"robot": 3}, "must be a robot, a name such as 'kneed'"),
        ({"robot": "wheel"}, "has no legs to walk with"),
        ({"robot": {"leg_mas": 4.0}}, "did you mean 'leg_mass'"),
        ({"robot": {"leg_mass": {"unifrm": [4.0, 5.0]}}}, "distribution of robot.leg_mass.*did you mean 'uniform'"),
        ({"robot": {"leg_mass": {"uniform": [5.0, 4.0]}}}, "robot.leg_mass.*lower end first"),
        ({"robot": {"leg_mass": {"uniform": [-1.0, 4.0]}}}, "leg_mass = -1.0: must be from"),
        ({"robot": {"leg_mass": {"uniform": [1.0, 4e7]}}}, "leg_mass = 40000000.0: must be from"),
        ({"robot": {"leg_mass": {"normal": [1.0, 0.3]}}}, "leg_mass = -0.199"),
        ({"terrain": {"name": "stair"}}, "did you mean 'stairs'"),
        ({"disturbances": "noise"}, "must be a mjbiped.Disturbances, or a table"),
        ({"disturbances": {"angle_nois": 0.1}}, "did you mean 'angle_noise'"),
        ({"disturbances": {"control_period": {"uniform": [0.004, 0.02]}}}, "cannot be drawn"),
        ({"disturbances": {"control_period": 0.016}}, "control_period = 0.02: must be a multiple of .*0.016 s"),
    ],
)
def test_mistakes_are_named(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        WalkTask("walk_level", **settings)


CURRICULUM: dict[str, Any] = {
    "easy": {"name": "random", "slope_deg": (-1.0, 1.0), "rise": (0.0, 0.0), "length": 15.0},
    "hard": {"slope_deg": (-6.0, 6.0), "rise": (-0.06, 0.0)},
}


def test_a_curriculum_goes_from_easy_to_hard_ground() -> None:
    ground = Curriculum(**CURRICULUM)
    task = WalkTask("walk_random", terrain=ground)
    steepest = []
    for difficulty in (0.0, 0.5, 1.0):
        episode = task.episode(np.random.default_rng(0), difficulty)
        assert episode.drawn["terrain.difficulty"] == difficulty
        assert dict(episode.terrain.parameters)["rise"] == (-0.06 * difficulty, 0.0)
        steepest.append(np.degrees(np.abs(episode.terrain.slope(np.linspace(0.0, 15.0, 200)))).max())
    assert np.all(np.diff(steepest) > 0.0)
    drawn = Curriculum({"name": "stairs", "rise": {"uniform": [-0.01, 0.0]}}, {"rise": {"uniform": [-0.03, -0.01]}})
    assert drawn.at(0.5) == {"name": "stairs", "rise": {"uniform": pytest.approx((-0.02, -0.005))}}
    assert Curriculum({"name": "stairs", "count": 2}, {"count": 9}).at(0.5) == {"name": "stairs", "count": 6}


def test_a_curriculum_follows_success_or_counts_episodes() -> None:
    by_success, by_number = Curriculum(**CURRICULUM), Curriculum(**CURRICULUM, step=0.25, by="episodes")
    assert by_success.after(0.5, Outcome.TIME_LIMIT) == by_success.after(0.5, Outcome.LEFT_TERRAIN) == 0.6
    assert by_success.after(0.5, Outcome.FELL) == 0.4
    assert by_success.after(0.0, Outcome.FELL) == 0.0
    assert by_number.after(0.9, Outcome.FELL) == 1.0


@pytest.mark.parametrize(("by", "expected"), [("success", [0.0, 0.5, 1.0, 1.0]), ("episodes", [0.0, 0.5, 1.0, 1.0])])
def test_each_robot_gets_on_by_itself_and_by_its_seed(by: Any, expected: list[float]) -> None:
    """With zero actions the adaptive controller walks to the end of each episode; a copy knows how far it has come."""
    options: Any = {"residual": True, "terrain": Curriculum(**CURRICULUM, step=0.5, by=by), "time_limit": 0.1}

    def walked(env: WalkEnv, episodes: int) -> list[tuple[float, float]]:
        found = []
        for _ in range(episodes):
            for _ in range(5):
                *_, info = env.step(np.zeros(2, dtype=np.float32))
            found.append((info["terrain.difficulty"], info["terrain.seed"]))
            env.reset()
        return found

    env = WalkEnv("walk_random", **options)
    env.reset(seed=1)
    first = walked(env, 3)
    copied = copy.deepcopy(env)
    assert walked(copied, 1) == (last := walked(env, 1))
    assert [difficulty for difficulty, _ in first + last] == expected
    env.reset(seed=1)
    assert walked(env, 4) == first + last
    many = WalkVectorEnv(2, "walk_random", **options)
    many.reset(seed=[0, 1])
    seen = []
    for _ in range(4 * 6 - 1):
        *_, info = many.step(np.zeros((2, 2), dtype=np.float32))
        seen.append((info["terrain.difficulty"][1], info["terrain.seed"][1]))
    assert list(dict.fromkeys(seen)) == first + last
    many.close()


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"hard": {"rise": -0.1}}, "have different forms"),
        ({"hard": {"raise": -0.1}}, "in `hard`.*'raise'.*did you mean 'rise'"),
        ({"hard": {"rise": (-2000.0, 0.0)}}, "rise"),
        ({"step": 2.0}, "step = 2.0: must be from 0 to 1"),
        ({"by": "luck"}, "unknown curriculum's `by` 'luck'"),
    ],
)
def test_mistakes_in_a_curriculum_are_named(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        WalkTask("walk_random", terrain=Curriculum(**{**CURRICULUM, **settings}))
