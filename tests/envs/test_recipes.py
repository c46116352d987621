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
from mjbiped.rules.termination import Outcome

DRAWN: dict[str, Any] = {
    "robot": {"leg_mass": {"uniform": [4.5, 5.5]}, "sole": [{"uniform": [0.05, 0.1]}, 0.15]},
    "terrain": {"name": "stairs", "rise": {"uniform": (-0.03, 0.0)}, "count": {"integer": [1, 9]}},
    "disturbances": {"friction": {"log_uniform": [0.5, 2.0]}, "rate_noise": {"normal": [0.05, 0.01]}},
}
CURRICULUM: dict[str, Any] = {
    "easy": {"name": "random", "slope_deg": (-1.0, 1.0), "rise": (0.0, 0.0), "length": 15.0},
    "hard": {"slope_deg": (-6.0, 6.0), "rise": (-0.06, 0.0)},
}
LIMIT = mjbiped.Disturbances(torque_limit=20.0, seed=3)


def drawn_by(task: WalkTask, seed: int = 0) -> Episode:
    return task.episode(np.random.default_rng(seed))


@pytest.mark.parametrize(
    ("settings", "name", "made"),
    [
        ({"robot": mjbiped.KneedBiped()}, "robot", mjbiped.KneedBiped()),
        ({"robot": {"kind": "compass", "leg_mass": 4.0}}, "robot", mjbiped.Compass(leg_mass=4.0)),
        ({"robot": {"sole": (0.05, 0.15)}}, "robot", mjbiped.Compass(sole=(0.05, 0.15))),
        ({"terrain": mjbiped.Terrain.stairs(rise=0.01)}, "terrain", mjbiped.Terrain.stairs(rise=0.01)),
        ({"name": "walk_stairs", "terrain": {"rise": 0.01}}, "terrain", mjbiped.Terrain.stairs(rise=0.01)),
        ({"terrain": "mixed"}, "terrain", mjbiped.Terrain.mixed()),
        ({"disturbances": LIMIT.to_dict()}, "disturbances", LIMIT),
    ],
)
def test_objects_names_and_tables_say_the_same(settings: dict[str, Any], name: str, made: object) -> None:
    assert getattr(drawn_by(WalkTask(**{"name": "walk_level", **settings})), name) == made


def test_an_episode_is_made_of_what_was_drawn_whatever_the_order_of_tables() -> None:
    task = WalkTask("walk_level", **DRAWN)
    episode = drawn_by(task)
    names = ["disturbances.friction", "disturbances.rate_noise", "disturbances.seed", "robot.leg_mass", "robot.sole.0"]
    assert list(episode.drawn) == [*names, "terrain.count", "terrain.rise"]
    sole = episode.drawn["robot.sole.0"], 0.15
    assert episode.robot == mjbiped.Compass(leg_mass=episode.drawn["robot.leg_mass"], sole=sole)
    for name in ("rise", "count"):
        assert dict(episode.terrain.parameters)[name] == episode.drawn[f"terrain.{name}"]
    for name, value in episode.disturbances.to_dict().items():
        assert value == episode.drawn[f"disturbances.{name}"]
    turned: Any = {name: dict(reversed(table.items())) for name, table in reversed(DRAWN.items())}
    assert drawn_by(task) == drawn_by(WalkTask("walk_level", **turned)) == episode
    assert drawn_by(task, 1).drawn != episode.drawn


def test_seeds_are_drawn_unless_given() -> None:
    assert "terrain.seed" in drawn_by(WalkTask("walk_level", terrain="waves")).drawn
    assert "disturbances.seed" in drawn_by(WalkTask("walk_level", disturbances={"angle_noise": 0.01})).drawn
    fixed = WalkTask("walk_random", terrain={"seed": 4}, disturbances={"angle_noise": 0.01, "seed": 0})
    assert drawn_by(fixed).drawn == {}
    assert drawn_by(fixed, 1).terrain is drawn_by(fixed, 2).terrain
    starts = np.array([drawn_by(fixed, seed).start for seed in range(50)]) / fixed.gait.start
    assert (starts[:, :2] == 1.0).all()
    assert ((starts[:, 2:] >= 0.95) & (starts[:, 2:] <= 1.05)).all()
    assert (np.ptp(starts[:, 2:], axis=0) > 0.08).all()


def test_the_controller_knows_the_medians() -> None:
    task = WalkTask("walk_level", residual=True, robot={"leg_mass": {"uniform": [4.0, 8.0]}, "hip_mass": 1.0})
    assert task.model == mjbiped.Compass(leg_mass=6.0, hip_mass=1.0)
    assert task.controller.inner.robot is task.model
    assert task.gait == mjbiped.find_passive_gait(task.model, np.radians(2.0))
    assert task.peak[0] == pytest.approx(35.55 * 1.3)  # 13 kg beside 10


def test_a_curriculum_goes_from_easy_to_hard_ground_by_success_or_by_episodes() -> None:
    task = WalkTask("walk_random", terrain=(ground := Curriculum(**CURRICULUM)))
    for difficulty in (0.0, 0.5, 1.0):
        episode = task.episode(np.random.default_rng(0), difficulty)
        assert episode.drawn["terrain.difficulty"] == difficulty
        assert dict(episode.terrain.parameters)["rise"] == (-0.06 * difficulty, 0.0)
        assert dict(episode.terrain.parameters)["slope_deg"] == (-1.0 - 5.0 * difficulty, 1.0 + 5.0 * difficulty)
    drawn = Curriculum({"name": "stairs", "rise": {"uniform": [-0.01, 0.0]}}, {"rise": {"uniform": [-0.03, -0.01]}})
    assert drawn.at(0.5) == {"name": "stairs", "rise": {"uniform": pytest.approx((-0.02, -0.005))}}
    assert Curriculum({"name": "stairs", "count": 2}, {"count": 9}).at(0.5) == {"name": "stairs", "count": 6}
    assert ground.after(0.5, Outcome.TIME_LIMIT) == ground.after(0.5, Outcome.LEFT_TERRAIN) == 0.6
    assert ground.after(0.5, Outcome.FELL) == 0.4
    assert ground.after(0.0, Outcome.FELL) == 0.0
    assert Curriculum(**CURRICULUM, step=0.25, by="episodes").after(0.9, Outcome.FELL) == 1.0


def test_each_robot_gets_on_by_itself_and_by_its_seed() -> None:
    """With zero actions the adaptive controller walks to the end of each episode; a copy knows how far it has come."""
    options: Any = {"residual": True, "terrain": Curriculum(**CURRICULUM, step=0.5), "time_limit": 0.1}

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
    assert [difficulty for difficulty, _ in first + last] == [0.0, 0.5, 1.0, 1.0]
    env.reset(seed=1)
    assert walked(env, 4) == first + last
    many = WalkVectorEnv(2, "walk_random", **options)
    many.reset(seed=[0, 1])
    infos = [many.step(np.zeros((2, 2), dtype=np.float32))[-1] for _ in range(4 * 6 - 1)]
    seen = [(info["terrain.difficulty"][1], info["terrain.seed"][1]) for info in infos]
    assert list(dict.fromkeys(seen)) == first + last
    many.close()
