"""Where MuJoCo keeps its numbers."""

import ctypes
import math

import mujoco
import numpy as np
import pytest
from simulations import make_simulation

import mjbiped
from controllers import PassiveController
from mjbiped.engines.mujoco.compiled import layout as native_layout
from mjbiped.engines.mujoco.compiled.layout import UnknownLayoutError, layout
from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.numerics.records import WORD

ARRAYS = ("qpos", "qvel", "ctrl", "userdata", "sensordata", "geom_xpos", "qacc")


@pytest.fixture(scope="module")
def simulation() -> Simulation:
    robot = mjbiped.Compass()
    return make_simulation(
        PassiveController(), mjbiped.Terrain.mixed(), robot=robot, q=(0.0, 0.0), dq=(0.0, 0.0), steps=9
    )


def word(address: int) -> int:
    return ctypes.c_int64.from_address(address).value


def number(address: int) -> float:
    return ctypes.c_double.from_address(address).value


def test_holds_for_a_walk(simulation: Simulation) -> None:
    """A model that the search has not seen, and a second mjData of it."""
    found, model = layout(), simulation.model
    for data in (simulation.data, mujoco.MjData(model)):
        for name in ARRAYS:
            assert word(data._address + getattr(found, name)) == getattr(data, name).ctypes.data, name
        data.time = math.pi
        assert number(data._address + found.time) == math.pi
    assert word(model._address + found.numerics) == model.nnumericdata
    assert word(model._address + found.numeric_data) == model.numeric_data.ctypes.data
    model.opt.timestep = math.e * 1e-5
    assert number(model._address + found.timestep) == math.e * 1e-5


def test_places_that_look_alike_are_refused() -> None:
    first, second = np.array([7, 1, 2, 7]), np.array([9, 9, 1, 9])
    with pytest.raises(UnknownLayoutError, match="userdata in 2 places"):
        native_layout._only_place("userdata", [first, second], [7, 9])
    with pytest.raises(UnknownLayoutError, match="userdata in 0 places"):
        native_layout._only_place("userdata", [first, second], [2, 9])
    assert native_layout._only_place("userdata", [first, second], [1, 9]) == WORD


def test_a_system_that_tells_no_sizes_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(native_layout, "_allocated", lambda _: 0)
    with pytest.raises(UnknownLayoutError, match="cannot be looked into"):
        layout.__wrapped__()
