"""The MuJoCo engine as a machine: machine code, memory, resuming, outcomes."""

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from simulations import assert_resumes, assert_same, make_simulation, recorded, started, state_of

import mjbiped
from controllers import AdaptiveController, Controller, Memory, PassiveController
from mjbiped.control.controller import Law
from mjbiped.engines.compiling import VARIABLE
from mjbiped.engines.mujoco import observation
from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.engines.mujoco.state import State
from mjbiped.numerics.sources import raises
from mjbiped.records import measures
from mjbiped.rules.termination import Outcome
from mjbiped.utils.domains import PLACE

Terrain = mjbiped.Terrain


RISER = Terrain.from_segments([(0.30, 2.0), (10.0, 2.0, 0.05)])
SLOW = pytest.mark.slow


@pytest.mark.compiled
@pytest.mark.parametrize(
    ("terrain", "settings"),
    [
        (Terrain.mixed(), {}),
        pytest.param(Terrain.level(), {"timestep": 1e-4, "lands": False}, marks=SLOW),
        pytest.param(Terrain.stairs(rise=-0.06), {"timestep": 2e-4}, marks=SLOW),
        pytest.param(Terrain.random(seed=3), {"sample_period": 5e-3}, marks=SLOW),
        pytest.param(Terrain.slopes(change_deg=1.5), {"control_period": 5e-3, "sample_period": 1e-3}, marks=SLOW),
        pytest.param(RISER, {}, marks=SLOW),  # struck, and then it falls
    ],
    ids=["mixed", "plain", "stairs", "random", "slow controller", "riser"],
)
def test_same_walk_bitwise(terrain: Terrain, settings: dict[str, Any], controller: AdaptiveController) -> None:
    """No tolerance: machine code does the same operations in the same order, and takes sines from the same library."""
    made = [started(controller, terrain, compile=compile, steps=3, **settings) for compile in (True, False)]
    assert [simulation.compiled for simulation in made] == [True, False]
    assert_same(recorded(made[0]), recorded(made[1]))
    assert made[0].state.count >= 1.0


@pytest.mark.compiled
def test_passive_walk_bitwise_to_its_end() -> None:
    """It falls: outcomes, too, are the same."""
    start: dict[str, Any] = {"robot": mjbiped.Compass(), "q": (-0.3, 0.3), "dq": (0.2, 0.1), "sample_period": 1e-3}
    made = [
        make_simulation(PassiveController(), Terrain.level(), compile=compile, **start) for compile in (True, False)
    ]
    assert_same(recorded(made[0]), recorded(made[1]))
    assert made[0].outcome is made[1].outcome is Outcome.FELL


def test_steps_can_be_made_until_a_time(controller: AdaptiveController) -> None:
    simulation = started(controller, Terrain.level())
    assert simulation.advance(10**6, 0.1) == 100
    assert simulation.data.time == pytest.approx(0.1, abs=1e-9)
    assert simulation.advance(10**6, 0.1) == 0


def three_torques(parameters: Any, memory: Memory, t: float, q: Any, dq: Any, out: Any) -> Any:
    return 0.0, 0.0, 0.0


def late_error(parameters: Any, memory: Memory, t: float, q: Any, dq: Any, out: Any) -> None:
    if t > 0.01:
        raise ValueError("late")
    out[0], out[1] = 0.0, 0.0


def out_of_range(parameters: Any, memory: Memory, t: float, q: Any, dq: Any, out: Any) -> None:
    out[0], out[1] = (0.0, 1.0)[int(100.0 * t)], 0.0


def with_torque(function: Any, *, in_python: bool = False) -> Controller:
    """A controller whose law has this torque."""

    class Wrong(PassiveController):
        def law(self) -> Law:
            return super().law()._replace(torque=function)

        if in_python:

            def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
                out = [0.0, 0.0]
                function([], memory, t, q, dq, out)
                return out

    return Wrong()


@pytest.mark.compiled
def test_values_that_are_returned_are_refused_in_words() -> None:
    with pytest.raises(mjbiped.InputError, match=r"torque returns .*; expected are 2 numbers written into out"):
        mjbiped.walk(with_torque(three_torques), Terrain.incline(2.0), steps=1)


@pytest.mark.compiled
def test_an_exception_in_compiled_code_stops_the_walk() -> None:
    with pytest.raises(mjbiped.WalkStopped, match=r"Wrong failed at .* a compiled law raised an exception") as stopped:
        mjbiped.walk(with_torque(out_of_range), Terrain.incline(2.0), steps=1)
    assert stopped.value.walk.outcome == "interrupted"
    assert 0.0199 < stopped.value.walk.end[0] < 0.0215  # the first step of 1 ms behind it


@pytest.mark.compiled
def test_a_law_that_raises_of_itself_runs_in_python() -> None:
    """A C function could not."""
    assert raises((late_error,))
    with pytest.raises(mjbiped.WalkStopped, match="ValueError: late"):
        mjbiped.walk(with_torque(late_error, in_python=True), Terrain.incline(2.0), steps=1)


@pytest.mark.compiled
def test_a_method_of_the_object_itself_is_called() -> None:
    def torque(memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        return 0.0, 1.0

    controller = PassiveController()
    object.__setattr__(controller, "torque", torque)
    simulation = started(controller, Terrain.mixed())
    simulation.advance(1)
    assert simulation.data.ctrl[2] == 1.0


def test_forward_calls_between_steps_change_nothing(controller: AdaptiveController) -> None:
    """Bitwise, about touchdowns too: whoever looks at the robot may ask MuJoCo where its parts are."""
    plain, disturbed = (started(controller, Terrain.mixed(), steps=2) for _ in range(2))
    while not disturbed.over:
        mujoco.mj_forward(disturbed.model, disturbed.data)
        disturbed.advance(1)
    plain.advance(10**6)
    assert plain.state.count == 2
    assert state_of(plain) == state_of(disturbed)


@pytest.mark.parametrize("settings", [{}, {"lands": False}], ids=["landing", "plain"])
def test_resumes_bitwise_from_any_moment(settings: dict[str, Any], controller: AdaptiveController) -> None:
    """Saved in mid-swing, just before a touchdown, between its contact step and the transfer, and just after it."""

    def build() -> Simulation:
        return started(controller, Terrain.mixed(), **settings)

    whole, saved, length, before = build(), {}, 0, (0.0, 0.0)
    while whole.state.count < 2.0 or whole.state.time < whole.state.transfer_time + 0.05:
        now = whole.state.noted, whole.state.count
        if length in (1, 300) or now != before:
            saved[length] = state_of(whole)
        before, length = now, length + whole.advance(1)
    assert len(saved) >= 6
    assert_resumes(saved, length, whole, build)


def test_the_time_at_the_sole_s_bound_is_that_with_less_torque_than_asked_for() -> None:
    """Of the ankle alone, the hip's differs at all times; samples of every step tell when, but about touchdowns."""
    robot, timestep = mjbiped.Compass(sole=(0.02, 0.02)), 1e-3
    controller = AdaptiveController(robot, mjbiped.find_passive_gait(robot, slope=np.deg2rad(2)))
    engine = mjbiped.Mujoco(timestep=timestep, lands=False)
    walk = mjbiped.walk(controller, Terrain.mixed(), engine=engine, steps=4, sample_period=timestep)
    bound = walk.samples["ankle_asked"] != walk.samples["torque"][:, 0]
    until = walk.samples["time"] < walk.touchdowns["time"][-1] - 0.5 * timestep
    assert 0.1 < walk.touchdowns["sole_bound_time"][-1] < 0.95 * walk.touchdowns["time"][-1]
    # a touchdown's own step and the one before it count for neither
    told = walk.touchdowns["sole_bound_time"][-1]
    assert told == pytest.approx(timestep * np.sum(bound & until), abs=2 * walk.steps * timestep)


def test_torques_act_on_the_stance_leg(controller: AdaptiveController) -> None:
    simulation = started(controller, Terrain.mixed(), timestep=5e-4)
    driven = []
    for _ in range(340):
        simulation.advance(10)
        left, right, hip = simulation.data.ctrl
        u = simulation.state
        stance = int(u.stance)
        assert (left, right)[1 - stance] == 0.0
        assert (left, right)[stance] == u.torque[0]
        assert hip == (-u.torque[1] if stance else u.torque[1])
        driven.append(stance)
    assert set(driven) == {0, 1}


@pytest.mark.parametrize(
    ("outcome", "parameters"),
    [
        ("fell", {"initial": (-0.3, 0.3, 0.2, 0.1), "terrain": Terrain.level()}),
        ("stalled", {"initial": "rest", "terrain": Terrain.level()}),
        ("finished", {"initial": "gait", "terrain": Terrain.incline(2.0), "steps": 2}),
        (
            "left the terrain",
            {"initial": "gait", "terrain": Terrain((0.0,), (0.0,), (math.radians(2),), end=0.5)},
        ),
    ],
)
def test_outcomes(outcome: str, parameters: dict[str, object]) -> None:
    walk = mjbiped.walk(PassiveController(), **parameters)  # type: ignore[arg-type]
    assert walk.outcome == outcome
    assert walk.fell == (outcome == "fell")
    assert walk.end[0] == walk.samples["time"][-1]
    assert walk.end[1] == walk.samples["qpos"][-1, 0]


class Push(Controller):
    """Pushes the stance leg with all its might, from the first moment after the start."""

    def __init__(self, ankle: float) -> None:
        self.ankle = ankle

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        return self.ankle if t > 0.0 else 0.0, 0.0


def test_slipping_is_an_outcome() -> None:
    """500 N m at the ankle ask for more than the friction cone holds."""
    walk = mjbiped.walk(Push(500.0), Terrain.level(), initial="rest")
    assert walk.outcome == "slipped"


@pytest.mark.parametrize(
    ("behind", "outcome"),
    [(0.2, Outcome.DIVERGED), (0.0, Outcome.DIVERGED), (-0.05, Outcome.WALKING)],
    ids=["under a step", "into the ground", "over an edge"],
)
def test_a_stance_foot_is_not_in_the_ground(behind: float, outcome: Outcome, controller: AdaptiveController) -> None:
    """It slides back by 10 mm and down by 30 mm, at the foot of a step, on the level, or at a step's edge."""
    u, c = State(), started(controller, Terrain((-1.0, -5e-3), (behind, 0.0), (0.0, 0.0))).constants
    here: dict[str, Any] = {"qpos": np.array([0.0, 1.0, 0.0, 0.0]), "qvel": np.zeros(4)}
    c = replace(c, **here)
    observation.begin(c, u, 0.0, 0.0)
    observation.observe(c, u, 0.0)
    assert u.outcome == Outcome.WALKING
    here["qpos"][:] = -0.01, 0.97, 0.0, 0.0
    observation.observe(c, u, 1e-3)
    assert u.outcome == outcome


@pytest.mark.parametrize(
    ("height", "outcome"), [(-0.03, Outcome.DIVERGED), (0.03, Outcome.DIVERGED), (0.0, Outcome.WALKING)]
)
def test_a_touchdown_off_the_ground_is_none(height: float, outcome: Outcome, controller: AdaptiveController) -> None:
    """A contact with what is not the ground under the foot: no row tells of it."""
    u, simulation = State(), started(controller, Terrain.level())
    here: dict[str, Any] = {"qpos": np.array([0.2, math.cos(0.2) + height, 0.2, -0.2]), "qvel": np.zeros(4)}
    c = replace(simulation.constants, **here)
    observation.begin(c, u, 0.0, height)
    u.noted = 1.0
    observation.observe(c, u, 0.0)
    assert u.outcome == outcome
    assert u.count == u.transferred == (outcome is Outcome.WALKING)


def test_a_walk_that_loses_the_ground_says_why(controller: AdaptiveController, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(observation, "MISSED", -1.0)  # no foot is on the ground
    monkeypatch.setenv(VARIABLE, "never")  # plain Python sees it
    walk = mjbiped.walk(controller, Terrain.level(), steps=1)
    assert (walk.outcome, walk.steps) == ("diverged", 0)
    (message,) = walk.warnings
    assert "the timestep is too long" in message


def test_a_stance_foot_that_leaves_the_ground_has_slipped() -> None:
    """The swing leg is thrown up, and takes the robot with it."""
    walk = mjbiped.walk(Push(0.0), Terrain.level(), initial=(0.0, 0.0, 0.0, 20.0))
    foot = walk.samples["qpos"][-1]
    assert foot[1] - math.cos(foot[2]) > 0.099  # a leg of 1 m; along the ground it moved by 0.057 m
    assert (walk.outcome, walk.steps) == ("slipped", 0)


def test_divergence_is_an_outcome(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # where MuJoCo would leave its log
    walk = mjbiped.walk(Push(math.nan), Terrain.level(), initial="rest")
    assert walk.outcome == "diverged"
    assert walk.steps == 0
    assert any("Push.torque gives nan for the ankle torque" in text for text in walk.warnings)
    assert not Path("MUJOCO_LOG.TXT").exists()


def test_swing_foot_passes_until_armed_and_strikes_risers() -> None:
    """A riser within the rule's reach is passed as if it were not there; one beyond it is struck, and counted."""
    near = Terrain.from_segments([(0.10, 2.0), (10.0, 2.0, 0.012)])
    far = Terrain.from_segments([(0.30, 2.0), (10.0, 2.0, 0.05)])
    walked = mjbiped.walk(PassiveController(), near, steps=1)
    assert walked.touchdowns["strikes"].sum() == 0
    struck = mjbiped.walk(PassiveController(), far, steps=1)
    # after the face impact the foot slides down the face: a touchdown before the riser, less than a step ahead
    assert struck.touchdowns["strikes"][0] == 1
    assert struck.touchdowns["x"][0] < 0.30


@pytest.mark.slow
@pytest.mark.parametrize(
    "terrain",
    [
        Terrain.from_segments([(0.62, -3.0), (5.0, -3.0, 0.035)]),
        Terrain.stairs(tread=0.5, rise=0.04, first=0.45),
        Terrain.stairs(tread=1.8, rise=0.04, first=0.6),
        *(Terrain.from_segments([(0.3778 * 2 - past, 0.0), (5.0, 0.0, -0.06)]) for past in (5e-5, 1.5e-4, 3e-4)),
        Terrain.from_segments([(0.3778 * 2 - 2.5e-3, -3.0), (5.0, -3.0, -0.06)]),
    ],
)
def test_footholds_are_on_the_ground(terrain: Terrain, controller: AdaptiveController) -> None:
    """Struck risers and footholds beside an edge: no foot stands on a riser's rim, and impacts stay impacts."""
    walk = mjbiped.walk(controller, terrain, steps=6)
    assert walk.steps >= 2
    touchdowns = walk.touchdowns
    near = [min(abs(x - start) for start in terrain.x) < 5e-4 for x in touchdowns["x"]]
    above = np.abs(touchdowns["z"] - terrain.height(touchdowns["x"]))
    assert above[~np.array(near)].max() < 2e-4  # penetration
    assert np.degrees(np.abs(touchdowns["slope"] - terrain.slope(touchdowns["x"])))[~np.array(near)].max() < 1e-3


def test_departing_foot_is_not_dragged() -> None:
    """A robot whose trailing foot leaves the ground obliquely: a convex friction cone would hold it in the impact."""
    goswami = mjbiped.Compass(leg_mass=5.0, hip_mass=10.0, leg_inertia=0.0)
    walk = mjbiped.walk(PassiveController(), Terrain.incline(3.0), steps=6, robot=goswami)
    assert walk.outcome == "finished"
    # 3e-3 rad/s of a contact resolved at h = 1e-4 (see test_walks), of a swing rate of 0.38 rad/s
    assert np.abs(measures.impact_errors(walk)).max() < 0.01


def test_sample_period_changes_no_result(controller: AdaptiveController) -> None:
    often, rarely = (
        mjbiped.walk(controller, Terrain.level(), steps=2, sample_period=period) for period in (1e-3, 100.0)
    )
    assert rarely.steps == often.steps == 2
    for name, column in often.touchdowns.items():
        assert np.array_equal(rarely.touchdowns[name], column), name
    assert np.array_equal(rarely.peak_torque, often.peak_torque)
    assert often.end == rarely.end


def test_lifted_leg_has_no_ankle_torque_between_ticks(controller: AdaptiveController) -> None:
    """A slow controller has not ticked yet when support is transferred: the motor of the leg in the air must be off."""
    simulation = started(controller, Terrain.mixed(), timestep=5e-4, control_period=1e-2)
    seen = 0
    while simulation.state.count < 3:
        simulation.advance(1)
        stance = int(simulation.state.stance)
        assert simulation.data.ctrl[1 - stance] == 0.0
        seen += int(simulation.state.transferred)
    assert seen > 10


@pytest.mark.parametrize(
    "bad",
    [
        {"timestep": 0.0},
        {"timestep": -1e-4},
        {"timestep": math.nan},
        {"timestep": 0.01},
        {"control_period": 7e-4},
        {"contact_timestep": 0.0},
        {"control_period": 0.0},
        {"control_period": math.inf},
    ],
)
def test_bad_times_are_refused(bad: dict[str, float], controller: AdaptiveController) -> None:
    with pytest.raises(mjbiped.InputError, match=next(iter(bad))):
        started(controller, Terrain.mixed(), **{"timestep": 5e-4, **bad})


def test_outcome_words() -> None:
    assert {outcome.words for outcome in Outcome} == {
        "walking",
        "finished",
        "fell",
        "stalled",
        "slipped",
        "left the terrain",
        "diverged",
        "unresolved",
        "interrupted",
        "time limit",
    }


@pytest.mark.parametrize("ground", ["auto", "boxes", "heightfield"])
def test_without_a_limit_the_ground_is_long_but_finite(ground: str, robot: mjbiped.Compass) -> None:
    simulation = started(PassiveController(), Terrain.stairs(count=2), robot=robot, steps=None, ground=ground)
    assert np.isfinite(simulation.model.geom_size).all()
    assert np.isfinite(simulation.model.geom_pos).all()
    assert simulation.constants.end == pytest.approx(PLACE.high, rel=1e-4)
