"""Disturbances on the command line, in study files, and in what is printed of a walk."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import mjbiped
from mjbiped.cli.walkers import disturbances_of, model_of
from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.errors import InputError
from mjbiped.studies.plan import plan


def test_options_say_what_the_fields_say() -> None:
    given = disturbances_of([("angle_noise", "0.01"), ("seed", "7"), ("torque_limit", "none")], [(2.0, -5.0)])
    assert given == Disturbances(angle_noise=0.01, seed=7, pushes=((2.0, -5.0),))
    assert disturbances_of([], []) is None


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ([("angl_noise", "1")], "--disturb unknown disturbance 'angl_noise'.*did you mean 'angle_noise'"),
        ([("delay", "soon")], "--disturb delay = 'soon': must be a finite number"),
        ([("delay", "0.1"), ("delay", "0.1")], "--disturb delay is given twice"),
        ([("pushes", "1")], "--disturb unknown disturbance 'pushes'"),
        ([("delay", "-1")], "delay = -1.0: must be from 0 to 1000 s"),
    ],
)
def test_options_that_make_no_sense_are_refused(given: list[tuple[str, str]], said: str) -> None:
    with pytest.raises(InputError, match=said):
        disturbances_of(given, [])


def test_a_model_error_is_a_factor_of_what_the_robot_is() -> None:
    robot = mjbiped.Compass(hip_mass=3.0)
    model = model_of(robot, [("leg_mass", 1.2), ("hip_mass", 0.5)])
    assert (model.leg_mass, model.hip_mass) == (1.2 * robot.leg_mass, 1.5)
    assert model.leg_inertia == robot.leg_inertia
    with pytest.raises(InputError, match="a name is given twice"):
        model_of(robot, [("leg_mass", 1.2), ("leg_mass", 1.2)])


def study(**sections: Any) -> Any:
    return plan(Path("study.toml"), {"steps": 3, "terrain": {"name": "level"}, **sections})


@pytest.mark.slow
def test_a_study_varies_disturbances() -> None:
    found = study(engine="hybrid", disturbances={"delay": [0.0, 0.05], "torque_limit": "none"})
    assert found.varied == ("disturbances.delay",)
    prompt, late = (cell.walk() for cell in found.cells)
    assert "disturbances" not in prompt.settings
    assert late.settings["disturbances"] == {"delay": 0.05}
    assert late.peak_torque.max() > prompt.peak_torque.max()


@pytest.mark.parametrize(
    ("sections", "said"),
    [
        ({"disturbances": {"delai": 0.1}}, "unknown setting of disturbances 'delai'"),
        ({"disturbances": {"delay": [0.01, 0.0105]}}, r"cell 1 \(disturbances.delay = 0.0105\): delay = 0.0105"),
        ({"disturbances": {"control_period": 0.0015}}, "must be a multiple of the timestep 0.001 s"),
        ({"disturbances": {"angle_noise": 2.0}}, "angle_noise = 2.0: must be from 0 to 1 rad"),
        ({"disturbances": {"seed": 0.5}}, "seed = 0.5: must be a whole number"),
    ],
)
def test_a_study_with_disturbances_that_no_walk_can_have_is_refused(sections: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        study(**sections)


@pytest.mark.slow
def test_a_summary_has_the_disturbances() -> None:
    law = _law()
    given = Disturbances(angle_noise=0.001, torque_limit=40.0, pushes=((1.0, -2.0),), seed=3)
    walk = mjbiped.walk(law, mjbiped.Terrain.level(), engine="hybrid", steps=2, disturbances=given)
    rows = {label: value for label, value, _ in walk.summary().rows}
    assert rows["disturbances"] == "angle noise 0.001, torque limit 40, pushes 1, seed 3"


def test_an_engine_that_knows_no_disturbances_refuses_them() -> None:
    class Own(mjbiped.Engine):
        name = "own"

        def start(self, *given: Any, **named: Any) -> Any:
            raise AssertionError("it has not refused")

    with pytest.raises(InputError, match="the engine own knows no disturbances"):
        mjbiped.walk(_law(), mjbiped.Terrain.level(), engine=Own(), disturbances=Disturbances(delay=0.1))


def test_a_step_in_which_the_ground_would_have_to_pull_is_marked() -> None:
    """A push forward on a leg that leans forward: the hybrid engine's foot stays all the same, MuJoCo's leaves it."""
    given = Disturbances(pushes=((0.65, 20.0),), push_duration=0.1)
    hybrid, mujoco = (
        mjbiped.walk(_law(), mjbiped.Terrain.level(), engine=engine, steps=4, disturbances=given)
        for engine in ("hybrid", "mujoco")
    )
    assert hybrid.ground_pulls.tolist() == [True, True, False, False]
    assert (hybrid.touchdowns["normal_force"][hybrid.ground_pulls] < 0.0).all()
    assert hybrid.summary()["steps_that_pull"] == 2
    assert mujoco.ground_pulls.tolist() == [True]
    assert mujoco.outcome == "slipped"


def _law() -> Any:
    from controllers import AdaptiveController

    robot = mjbiped.Compass()
    return AdaptiveController(robot, mjbiped.find_passive_gait(robot, 0.03490658503988659))
