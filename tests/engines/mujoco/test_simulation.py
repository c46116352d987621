"""The MuJoCo engine as a machine: callbacks, memory, resuming, outcomes."""

import math
import re
import textwrap
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from simulations import make_simulation

import mjbiped
from controllers import AdaptiveController, Controller, Memory, PassiveController
from mjbiped.engines.mujoco import observation
from mjbiped.engines.mujoco.simulation import Simulation, _parts
from mjbiped.engines.mujoco.state import State
from mjbiped.records import measures
from mjbiped.records.rows import rows_of
from mjbiped.rules.termination import Outcome
from mjbiped.utils.domains import PLACE

STATE = mujoco.mjtState.mjSTATE_INTEGRATION
STEPS = 3800  # of the physics: three touchdowns from rest
CALLBACKS = ("control", "sensor", "contactfilter")


def make(controller: Controller, terrain: mjbiped.Terrain | None = None, **parameters: object) -> Simulation:
    arguments: dict[str, Any] = {
        "robot": mjbiped.Compass(),
        "q": (0.0, 0.0),
        "dq": (0.0, 0.0),
        "steps": 60,
        "timestep": 5e-4,
    }
    return make_simulation(controller, terrain or mjbiped.Terrain.mixed(), **{**arguments, **parameters})


def state_of(simulation: Simulation) -> bytes:
    state = np.zeros(mujoco.mj_stateSize(simulation.model, STATE))
    mujoco.mj_getState(simulation.model, simulation.data, state, STATE)
    return state.tobytes()


def test_example_of_the_docstring_runs() -> None:
    """As it stands, with the names that a reader has imported."""
    example = re.search(r"```python\n(.*?)```", Simulation.__doc__ or "", re.DOTALL)
    assert example
    names: dict[str, Any] = {name: globals()[name] for name in ("AdaptiveController", "mjbiped", "mujoco", "np")}
    exec(textwrap.dedent(example[1]), names)
    assert names["simulation"].data.time > 0.1
    assert names["simulation"].outcome is Outcome.WALKING


def test_the_time_at_the_sole_s_bound_is_that_with_less_torque_than_asked_for() -> None:
    """Of the ankle alone, the hip's differs at all times; samples of every step tell when, but about touchdowns."""
    robot, timestep = mjbiped.Compass(sole=(0.02, 0.02)), 1e-3
    controller = AdaptiveController(robot, mjbiped.find_passive_gait(robot, slope=np.deg2rad(2)))
    engine = mjbiped.Mujoco(timestep=timestep, lands=False)
    walk = mjbiped.walk(controller, mjbiped.Terrain.mixed(), engine=engine, steps=4, sample_period=timestep)
    bound = walk.samples["ankle_asked"] != walk.samples["torque"][:, 0]
    until = walk.samples["time"] < walk.touchdowns["time"][-1] - 0.5 * timestep
    assert 0.1 < walk.touchdowns["sole_bound_time"][-1] < 0.95 * walk.touchdowns["time"][-1]
    # a touchdown's own step and the one before it count for neither
    told = walk.touchdowns["sole_bound_time"][-1]
    assert told == pytest.approx(timestep * np.sum(bound & until), abs=2 * walk.steps * timestep)


def test_extra_forward_calls_change_nothing(controller: AdaptiveController) -> None:
    """Bitwise: a viewer or an integrator may fire the callbacks again at the same time."""
    plain, disturbed = make(controller), make(controller)
    with plain.callbacks():
        mujoco.mj_step(plain.model, plain.data, nstep=STEPS)
    with disturbed.callbacks():
        for step in range(STEPS):
            if step % 7 == 0 or disturbed.state.enabled:  # at every step until a touchdown
                mujoco.mj_forward(disturbed.model, disturbed.data)
            if step % 11 == 0:
                mujoco.mj_forward(disturbed.model, disturbed.data)
            mujoco.mj_step(disturbed.model, disturbed.data)
    assert plain.state.count == 2
    assert state_of(plain) == state_of(disturbed)


def test_resumes_bitwise_from_any_moment(controller: AdaptiveController) -> None:
    """Saved in mid-swing, just before a touchdown, between its contact step and the transfer, and just after it."""
    length = STEPS
    whole = make(controller)
    saved: dict[int, np.ndarray] = {}
    with whole.callbacks():
        for step in range(length):
            noted = bool(whole.state.noted)
            before = int(whole.state.count)
            if step in (1, 800) or (noted and before == 0):
                saved[step] = np.frombuffer(state_of(whole)).copy()
            mujoco.mj_step(whole.model, whole.data)
            if whole.state.count > before:
                saved[step + 1] = np.frombuffer(state_of(whole)).copy()
    assert len(saved) >= 5
    for step, state in saved.items():
        resumed = make(controller)
        mujoco.mj_setState(resumed.model, resumed.data, state, STATE)
        with resumed.callbacks():
            mujoco.mj_step(resumed.model, resumed.data, nstep=length - step)
        assert state_of(resumed) == state_of(whole), f"saved at step {step}"


def test_zeroed_userdata_does_nothing(controller: AdaptiveController) -> None:
    simulation = make(controller)
    mujoco.mj_resetData(simulation.model, simulation.data)
    with simulation.callbacks():
        mujoco.mj_step(simulation.model, simulation.data, nstep=10)
    assert not simulation.data.ctrl.any()
    assert not simulation.data.userdata.any()


@pytest.mark.parametrize("how", ["normal", "exception", "ctrl-c"])
def test_callbacks_are_always_restored(how: str, controller: AdaptiveController) -> None:
    def standing_there(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        del model, data

    class Broken(PassiveController):
        def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
            raise {"exception": ValueError, "ctrl-c": KeyboardInterrupt}[how]("broken")

    simulation = make(Broken() if how != "normal" else controller)
    mujoco.set_mjcb_control(standing_there)
    try:
        try:
            with simulation.callbacks():
                mujoco.mj_step(simulation.model, simulation.data, nstep=3)
            assert how == "normal"
        except (ValueError, KeyboardInterrupt):
            assert how != "normal"
        assert mujoco.get_mjcb_control() is standing_there
        assert mujoco.get_mjcb_sensor() is None
        assert mujoco.get_mjcb_contactfilter() is None
    finally:
        mujoco.set_mjcb_control(None)


def test_other_models_are_left_alone(controller: AdaptiveController) -> None:
    """Callbacks are process-wide: another model that is stepped meanwhile must not be driven."""
    falling = "<mujoco><worldbody><body><freejoint/><geom size='1'/></body></worldbody></mujoco>"
    other = mujoco.MjModel.from_xml_string(falling)
    data = mujoco.MjData(other)
    with make(controller).callbacks():
        mujoco.mj_step(other, data)
    assert data.time == other.opt.timestep


def test_torques_act_on_the_stance_leg(controller: AdaptiveController) -> None:
    simulation = make(controller)
    driven = []
    with simulation.callbacks():
        for _ in range(340):
            mujoco.mj_step(simulation.model, simulation.data, nstep=10)
            left, right, hip = simulation.data.ctrl
            u = simulation.state
            stance = int(u.stance)
            assert (left, right)[1 - stance] == 0.0
            assert (left, right)[stance] == u.torque[0]
            assert hip == (-u.torque[1] if stance else u.torque[1])
            driven.append(stance)
    assert set(driven) == {0, 1}


class Constant(Controller):
    """A constant hip torque, and a count of its ticks."""

    states = ("ticks",)
    memory_size = 1

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        return 0.0, 0.5, 1.0


def test_controller_ticks_once_per_control_period() -> None:
    """It is asked at the times that it should be, and the state whose rate is 1 is a clock."""
    asked: list[float] = []

    class Asked(Constant):
        def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
            asked.append(t)
            assert memory[0] == pytest.approx(t, abs=1e-15)
            return super().torque(memory, t, q, dq)

    simulation = make(Asked(), timestep=5e-4, control_period=2e-3)
    with simulation.callbacks():
        mujoco.mj_step(simulation.model, simulation.data, nstep=20)
    assert asked == pytest.approx([0.0, 2e-3, 4e-3, 6e-3, 8e-3], abs=1e-15)


def test_work_is_torque_times_way() -> None:
    """Independent of the engine's own sums: a constant torque's work is the torque times the angle it moved through."""
    simulation = make(Constant(), q=(0.0, 0.0), dq=(0.0, 0.0))
    with simulation.callbacks():
        mujoco.mj_step(simulation.model, simulation.data, nstep=401)
        mujoco.mj_forward(simulation.model, simulation.data)  # counts the last step's work
    left, right = simulation.data.qpos[2:]
    # sums of 400 roundings
    assert simulation.state.work_net == pytest.approx(0.5 * (right - left), rel=1e-10)


@pytest.mark.parametrize(
    ("outcome", "parameters"),
    [
        ("fell", {"initial": (-0.3, 0.3, 0.2, 0.1), "terrain": mjbiped.Terrain.level()}),
        ("stalled", {"initial": "rest", "terrain": mjbiped.Terrain.level()}),
        ("finished", {"initial": "gait", "terrain": mjbiped.Terrain.incline(2.0), "steps": 2}),
        (
            "left the terrain",
            {"initial": "gait", "terrain": mjbiped.Terrain((0.0,), (0.0,), (math.radians(2),), end=0.5)},
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
    walk = mjbiped.walk(Push(500.0), mjbiped.Terrain.level(), initial="rest")
    assert walk.outcome == "slipped"


@pytest.mark.parametrize(
    ("behind", "outcome"),
    [(0.2, Outcome.DIVERGED), (0.0, Outcome.DIVERGED), (-0.05, Outcome.WALKING)],
    ids=["under a step", "into the ground", "over an edge"],
)
def test_a_stance_foot_is_not_in_the_ground(behind: float, outcome: Outcome, controller: AdaptiveController) -> None:
    """It slides back by 10 mm and down by 30 mm, at the foot of a step, on the level, or at a step's edge."""
    terrain = mjbiped.Terrain((-1.0, -5e-3), (behind, 0.0), (0.0, 0.0))
    walker = make_simulation(controller, terrain, robot=controller.robot, q=(0.0, 0.0), dq=(0.0, 0.0))
    u, at_rest = State(), (0.0, 0.0, 0.0, 0.0)
    observation.begin(walker.constants, u, (0.0, 1.0, 0.0, 0.0), at_rest, 0.0, 0.0)
    observation.observe(None, walker.constants, u, [], 0.0, (0.0, 1.0, 0.0, 0.0), at_rest)
    assert u.outcome == Outcome.WALKING
    observation.observe(None, walker.constants, u, [], 1e-3, (-0.01, 0.97, 0.0, 0.0), at_rest)
    assert u.outcome == outcome


@pytest.mark.parametrize(
    ("height", "outcome"), [(-0.03, Outcome.DIVERGED), (0.03, Outcome.DIVERGED), (0.0, Outcome.WALKING)]
)
def test_a_touchdown_off_the_ground_is_none(height: float, outcome: Outcome, controller: AdaptiveController) -> None:
    """A contact with what is not the ground under the foot: no row tells of it."""
    terrain = mjbiped.Terrain.level()
    walker = make_simulation(controller, terrain, robot=controller.robot, q=(0.0, 0.0), dq=(0.0, 0.0))
    u, qpos, at_rest = State(), (0.2, math.cos(0.2) + height, 0.2, -0.2), (0.0, 0.0, 0.0, 0.0)
    observation.begin(walker.constants, u, qpos, at_rest, 0.0, height)
    u.noted = 1.0
    parts, row = _parts(rows_of(mjbiped.Compass)), [0.0] * walker.constants.touched
    observation.observe(parts, walker.constants, u, row, 0.0, qpos, at_rest)
    assert u.outcome == outcome
    assert u.count == u.transferred == (outcome is Outcome.WALKING)


def test_a_walk_that_loses_the_ground_says_why(controller: AdaptiveController, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(observation, "MISSED", -1.0)  # no foot is on the ground
    monkeypatch.setattr(Simulation, "native", None)  # callbacks in Python see it
    walk = mjbiped.walk(controller, mjbiped.Terrain.level(), steps=1)
    assert (walk.outcome, walk.steps) == ("diverged", 0)
    (message,) = walk.warnings
    assert "the timestep is too long" in message


def test_a_stance_foot_that_leaves_the_ground_has_slipped() -> None:
    """The swing leg is thrown up, and takes the robot with it."""
    walk = mjbiped.walk(Push(0.0), mjbiped.Terrain.level(), initial=(0.0, 0.0, 0.0, 20.0))
    foot = walk.samples["qpos"][-1]
    assert foot[1] - math.cos(foot[2]) > 0.099  # a leg of 1 m; along the ground it moved by 0.057 m
    assert (walk.outcome, walk.steps) == ("slipped", 0)


def test_divergence_is_an_outcome(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # where MuJoCo would leave its log
    walk = mjbiped.walk(Push(math.nan), mjbiped.Terrain.level(), initial="rest")
    assert walk.outcome == "diverged"
    assert walk.steps == 0
    assert any("Push.torque gives nan for the ankle torque" in text for text in walk.warnings)
    assert not Path("MUJOCO_LOG.TXT").exists()


def test_swing_foot_passes_until_armed_and_strikes_risers() -> None:
    """A riser within the rule's reach is passed as if it were not there; one beyond it is struck, and counted."""
    near = mjbiped.Terrain.from_segments([(0.10, 2.0), (10.0, 2.0, 0.012)])
    far = mjbiped.Terrain.from_segments([(0.30, 2.0), (10.0, 2.0, 0.05)])
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
        mjbiped.Terrain.from_segments([(0.62, -3.0), (5.0, -3.0, 0.035)]),
        mjbiped.Terrain.stairs(tread=0.5, rise=0.04, first=0.45),
        mjbiped.Terrain.stairs(tread=1.8, rise=0.04, first=0.6),
        *(
            mjbiped.Terrain.from_segments([(0.3778 * 2 - past, 0.0), (5.0, 0.0, -0.06)])
            for past in (5e-5, 1.5e-4, 3e-4)
        ),
        mjbiped.Terrain.from_segments([(0.3778 * 2 - 2.5e-3, -3.0), (5.0, -3.0, -0.06)]),
    ],
)
def test_footholds_are_on_the_ground(terrain: mjbiped.Terrain, controller: AdaptiveController) -> None:
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
    walk = mjbiped.walk(PassiveController(), mjbiped.Terrain.incline(3.0), steps=6, robot=goswami)
    assert walk.outcome == "finished"
    # 3e-3 rad/s of a contact resolved at h = 1e-4 (see test_walks), of a swing rate of 0.38 rad/s
    assert np.abs(measures.impact_errors(walk)).max() < 0.01


def test_sample_period_changes_no_result(controller: AdaptiveController) -> None:
    often, rarely = (
        mjbiped.walk(controller, mjbiped.Terrain.level(), steps=2, sample_period=period) for period in (1e-3, 100.0)
    )
    assert rarely.steps == often.steps == 2
    for name, column in often.touchdowns.items():
        assert np.array_equal(rarely.touchdowns[name], column), name
    assert np.array_equal(rarely.peak_torque, often.peak_torque)
    assert often.end == rarely.end


def test_nested_simulations_are_both_driven(controller: AdaptiveController) -> None:
    alone, outer, inner = (make(controller) for _ in range(3))
    with alone.callbacks():
        mujoco.mj_step(alone.model, alone.data, nstep=600)
    with outer.callbacks(), inner.callbacks():
        for simulation in (outer, inner):
            mujoco.mj_step(simulation.model, simulation.data, nstep=600)
    assert state_of(alone) == state_of(outer) == state_of(inner)


def test_lifted_leg_has_no_ankle_torque_between_ticks(controller: AdaptiveController) -> None:
    """A slow controller has not ticked yet when support is transferred: the motor of the leg in the air must be off."""
    simulation = make(controller, control_period=1e-2)
    seen = 0
    with simulation.callbacks():
        while simulation.state.count < 3:
            mujoco.mj_step(simulation.model, simulation.data)
            stance = int(simulation.state.stance)
            assert simulation.data.ctrl[1 - stance] == 0.0
            seen += int(simulation.state.transferred)
    assert seen > 10


def test_runs_in_a_thread_as_well(controller: AdaptiveController) -> None:
    walks: list[mjbiped.Walk] = []
    thread = threading.Thread(target=lambda: walks.append(mjbiped.walk(controller, mjbiped.Terrain.level(), steps=1)))
    thread.start()
    thread.join()
    assert walks[0] == mjbiped.walk(controller, mjbiped.Terrain.level(), steps=1)


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
        make(controller, **bad)  # type: ignore[arg-type]


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
    arguments: dict[str, Any] = {"robot": robot, "q": (0.0, 0.0), "dq": (0.0, 0.0), "ground": ground}
    simulation = make_simulation(PassiveController(), mjbiped.Terrain.stairs(count=2), **arguments)
    assert np.isfinite(simulation.model.geom_size).all()
    assert np.isfinite(simulation.model.geom_pos).all()
    assert simulation.limits.end == pytest.approx(PLACE.high, rel=1e-4)
