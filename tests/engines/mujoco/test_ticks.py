"""Rows of simulations: what stands in MuJoCo's globals before and after, and who else may be there."""

import ctypes
import threading
from collections.abc import Iterator

import mujoco
import numpy as np
import pytest
from simulations import make_simulation

import mjbiped
from controllers import AdaptiveController
from mjbiped.control.unpowered import Unpowered
from mjbiped.engines.mujoco.compiled import registry
from mjbiped.engines.mujoco.compiled.layout import library
from mjbiped.envs.tasks import WalkTask
from mjbiped.envs.walkers import Walkers
from mjbiped.terrain.terrain import Terrain


@pytest.fixture
def walkers() -> Iterator[Walkers]:
    made = Walkers(WalkTask("walk_level", residual=True), 2, threads=2)
    for index in range(2):
        made.begin(index, np.random.default_rng(index))
    yield made
    made.close()


@pytest.mark.slow
@pytest.mark.parametrize("threads", [1, 2])
def test_nothing_is_left_in_mujocos_globals(threads: int) -> None:
    """The pointers themselves: what Python's bindings tell of them is not asked."""
    names = (*registry.CALLBACKS, "mju_user_warning", "mjcb_time")
    pointers = [ctypes.c_void_p.in_dll(library(), name) for name in names]
    before = [pointer.value for pointer in pointers]
    made = Walkers(WalkTask("walk_level"), 2, threads=threads)
    for index in range(2):
        made.begin(index, np.random.default_rng(index))
    made.step()
    assert before[-1], "MuJoCo's clock, which walks take away meanwhile"
    assert [pointer.value for pointer in pointers] == before
    made.close()


def test_who_hears_mujocos_warnings_hears_them_again() -> None:
    """As dm_control does: after a step, and after a walk in Python that begins and ends within compiled ones."""
    heard: list[str] = []
    place = ctypes.c_void_p.in_dll(library(), "mju_user_warning")
    made = Walkers(WalkTask("walk_level"))
    made.begin(0, np.random.default_rng(0))
    robot, start = mjbiped.Compass(), ([-0.19, 0.19], [1.1, 0.8])
    in_python = make_simulation(Unpowered(), Terrain.level(), robot=robot, q=start[0], dq=start[1], compile=False)
    mujoco.set_mju_user_warning(heard.append)
    try:
        before, standing = place.value, mujoco.get_mju_user_warning()
        made.step()
        assert (place.value, mujoco.get_mju_user_warning()) == (before, standing)
        with registry.compiled():
            assert place.value != before
            with in_python.callbacks():
                mujoco.mj_step(in_python.model, in_python.data, nstep=2)
        assert (place.value, mujoco.get_mju_user_warning()) == (before, standing)
        made.step()
        assert place.value == before
    finally:
        mujoco.set_mju_user_warning(None)
    made.close()


@pytest.mark.slow
@pytest.mark.parametrize("threads", [1, 2])
def test_others_callbacks_are_asked_for_their_models_and_stay(threads: int) -> None:
    """The robots walk as they do without them, bit by bit."""
    other = mujoco.MjModel.from_xml_string("<mujoco/>")
    seen: list[mujoco.MjModel] = []

    def theirs(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        seen.append(model)

    felt = []
    for callback in (None, theirs):
        made = Walkers(WalkTask("walk_level", residual=True), 2, threads=threads)
        mujoco.set_mjcb_control(callback)
        try:
            for index in range(2):
                made.begin(index, np.random.default_rng(index))
            for _ in range(30):
                made.step()
            assert mujoco.get_mjcb_control() is callback
            mujoco.mj_forward(other, mujoco.MjData(other))
        finally:
            mujoco.set_mjcb_control(None)
        felt.append(made.felt.copy())
        made.close()
    np.testing.assert_array_equal(felt[0], felt[1])
    assert seen == [other]


def test_it_can_be_stepped_within_the_compiled_callbacks_of_a_walk(
    walkers: Walkers, controller: AdaptiveController
) -> None:
    start = controller.gait.start
    simulation = make_simulation(
        controller, Terrain.level(), robot=controller.robot, q=start[:2].tolist(), dq=start[2:].tolist(), steps=3
    )
    with simulation.callbacks():
        mujoco.mj_step(simulation.model, simulation.data, nstep=10)
        walkers.step()
        mujoco.mj_step(simulation.model, simulation.data, nstep=10)
    assert simulation.state.running == 1.0


def test_environments_in_two_threads_do_not_mix(controller: AdaptiveController) -> None:
    """Each is bitwise as alone."""
    task = WalkTask("walk_random", residual=True)
    rows: list[list[bytes]] = [[], []]

    def episodes(into: list[bytes]) -> None:
        one = Walkers(task)
        one.begin(0, np.random.default_rng(3))
        for _ in range(150):
            one.step()
            into.append(one.felt.tobytes())

    threads = [threading.Thread(target=episodes, args=(into,)) for into in rows]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    alone: list[bytes] = []
    episodes(alone)
    assert rows[0] == rows[1] == alone


def test_a_walk_can_be_made_between_two_steps(walkers: Walkers, controller: AdaptiveController) -> None:
    walkers.step()
    walk = mjbiped.walk(controller, Terrain.level(), steps=1, sample_period=None)
    walkers.step()
    assert walk.outcome == "finished"
