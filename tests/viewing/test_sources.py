"""What the viewer does to the walk: nothing, unless somebody pushes. No screen is needed."""

import math
from collections.abc import Callable, Iterator
from contextlib import ExitStack

import mujoco
import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController, Controller
from mjbiped import Mujoco, ScuffingRule, WalkStopped
from mjbiped.control.controller import Memory
from mjbiped.control.registry import make_controller
from mjbiped.engines.plan import Terms, make_plan
from mjbiped.viewing import KEYS, Player
from mjbiped.viewing.sources import LiveWalk

STEPS = 3
Terrain = mjbiped.Terrain
MIXED = Terrain.mixed()
Watch = Callable[..., LiveWalk]


@pytest.fixture
def watch() -> Iterator[Watch]:
    """Begins a walk in MuJoCo, of which a test that fails leaves no callbacks to the next."""
    with ExitStack() as stack:

        def begin(law: Controller, terrain: Terrain = MIXED, steps: int = STEPS, ground: str = "auto") -> LiveWalk:
            terms = Terms(Mujoco(ground=ground), steps, None, None, None, ScuffingRule())
            live = LiveWalk(make_plan(terms, law, terrain, "gait"))
            stack.callback(live.close)
            return live

        yield begin


LONG = Terrain.from_segments([(0.05, 0.3 * (-1) ** n, 0.0) for n in range(3000)])  # more than one window


def seen_to_its_end(live: LiveWalk) -> dict[str, np.ndarray]:
    """Watch without a screen, in frames of whatever length; show() and moment() as the window calls them."""
    time = 0.0
    while not live.ended:
        time += 0.017
        live.go_to(time)
        live.show()
        live.moment()
    return live.run.recorder.touchdowns()


def same(touchdowns: dict[str, np.ndarray], walk: mjbiped.Walk) -> bool:
    """Bitwise, NaN being NaN."""
    assert len(touchdowns["time"]) > 1
    return all(touchdowns[name].tobytes() == walk.touchdowns[name].tobytes() for name in walk.touchdowns)


@pytest.mark.parametrize("terrain", [MIXED, pytest.param(LONG, marks=pytest.mark.slow)])
def test_watching_changes_no_bit(watch: Watch, controller: AdaptiveController, terrain: Terrain) -> None:
    steps = 24 if terrain is LONG else STEPS
    live = watch(controller, terrain, steps)
    first = live.model
    touchdowns = seen_to_its_end(live)
    assert same(touchdowns, mjbiped.walk(controller, terrain, steps=steps))
    assert live.ended == "finished"
    assert (live.model is not first) == (terrain is LONG)  # the window's model has moved on


@pytest.mark.slow
def test_pauses_speeds_strides_and_restarts_change_nothing(watch: Watch, controller: AdaptiveController) -> None:
    live = watch(controller)
    player = Player(live)
    keys = "pause forward slower pause next_touchdown pause faster faster restart back pause".split()  # noqa: SIM905
    for number, key in enumerate(keys):
        player.press(KEYS[key].codes[0])
        for _ in range(5 + number):
            player.tick(0.013)
    while not live.ended:
        player.tick(0.05)
    assert same(live.run.recorder.touchdowns(), mjbiped.walk(controller, MIXED, steps=STEPS))


@pytest.mark.slow
def test_a_push_changes_the_walk_and_landings_still_end_steps(watch: Watch, controller: AdaptiveController) -> None:
    live = watch(controller)
    pull = mujoco.MjvPerturb()
    live.go_to(1.0)
    live.show()
    scene = mujoco.MjvScene(live.model, maxgeom=2000)
    eye, every = mujoco.MjvCamera(), mujoco.mjtCatBit.mjCAT_ALL
    mujoco.mjv_updateScene(live.model, live.data, mujoco.MjvOption(), pull, eye, every, scene)
    pull.select = live.model.body("hip").id
    mujoco.mjv_initPerturb(live.model, live.data, scene, pull)
    pull.refselpos[0] += 0.15  # forward, m
    pull.active = mujoco.mjtPertBit.mjPERT_TRANSLATE
    live.push(pull)
    live.go_to(1.3)
    assert live.run.simulation.data.xfrc_applied[pull.select, 0] > 0.0
    pull.active = 0
    live.push(pull)
    pushed = seen_to_its_end(live)
    assert not live.run.simulation.data.xfrc_applied.any()
    plain = mjbiped.walk(controller, MIXED, steps=STEPS).touchdowns
    before = plain["time"] < 1.0
    assert before.any()
    assert pushed["time"][: before.sum()].tobytes() == plain["time"][before].tobytes()
    assert abs(pushed["time"] - plain["time"])[before.sum()] > 1e-3  # without the push not a bit would differ
    # steps still end where the ground is met: no touchdown is deeper than the engine's own without a push, some 10 µm
    assert pushed["penetration"].max() < 5e-5


@pytest.mark.parametrize("ground", ["heightfield", "boxes"])  # the foot is a contact's second geom, or its first
def test_the_force_drawn_is_that_of_the_contacts(watch: Watch, controller: AdaptiveController, ground: str) -> None:
    """Of the equations of motion it is known independently; contacts agree on it in the middle of a step."""
    live = watch(controller, ground=ground)
    live.go_to(1.0)
    live.moment()
    u = live.run.simulation.state
    while u.time - u.transfer_time < 0.3:  # the middle of a step
        live.go_to(live.time + 0.001)
        live.moment()
    live.go_to(live.time + 0.05)
    moment = live.moment()
    q, dq = (u.angles[0], u.angles[1]), (u.turning[0], u.turning[1])
    expected = mjbiped.Compass().ground_force(q, dq, moment.torque, moment.slope)
    # a mean over 50 ms, in which the force changes by some percent
    assert moment.force == pytest.approx(expected, rel=0.1, abs=0.05 * live.robot.weight)


def test_a_robot_with_knees_is_watched_too(watch: Watch) -> None:
    """It once ended at the first step, for its posture has more than two angles."""
    robot = mjbiped.KneedBiped()
    law = make_controller("adaptive", robot, {})
    live = watch(law, Terrain.level(), 2)
    live.go_to(0.5)
    moment = live.moment()
    assert (len(moment.qpos), len(moment.torque)) == (6, 3)
    assert robot.limbs(moment.qpos)[moment.stance, -1, 1] == pytest.approx(0.0, abs=1e-4)
    assert moment.reference == pytest.approx(moment.qpos, abs=1e-2)
    assert same(seen_to_its_end(live), mjbiped.walk(law, Terrain.level(), steps=2))


def test_the_window_does_nothing_to_the_walk(watch: Watch, controller: AdaptiveController) -> None:
    live = watch(controller)
    while not live.ended:
        live.go_to(live.time + 0.3)
        live.show()
        live.data.qpos[:] += 1.0
        live.data.xfrc_applied[:] = math.pi
        live.model.opt.gravity[:] = 0.0
        mujoco.mj_forward(live.model, live.data)  # as the viewer does when it opens
    assert same(live.run.recorder.touchdowns(), mjbiped.walk(controller, MIXED, steps=STEPS))


def test_a_law_that_fails_ends_it_in_words(watch: Watch) -> None:
    class Failing(Controller):
        def torque(self, memory: Memory, t: float, q: object, dq: object) -> tuple[float, float]:
            if t > 0.2:
                raise ZeroDivisionError("oh")
            return 0.0, 0.0

    live = watch(Failing(), Terrain.incline(2.0))
    with pytest.raises(WalkStopped, match=r"Failing failed at 0\.(19|20). s"):
        live.go_to(5.0)
    assert mujoco.get_mjcb_control() is None


def test_a_robot_in_space_is_watched_from_its_record(watch: Watch) -> None:
    with pytest.raises(mjbiped.InputError, match="record its walk"):
        watch(make_controller("adaptive", mjbiped.Compass3D(), {}), Terrain.level())
