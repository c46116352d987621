"""The stages of a physics step with knees for compiled code, which calls MuJoCo's functions by their addresses.

This module imports Numba: import it where something is compiled, not before.
"""

from __future__ import annotations

import ctypes
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjbiped.engines.mujoco.compiled.layout import layout, library
from mjbiped.numerics.addresses import call_with


class Machine(NamedTuple):
    """What the stages are called with.

    Attributes:
        model: Address of the mjModel.
        data: Address of the mjData.
        fwd_position: Address of `mj_fwdPosition`, as of the others.
        fwd_velocity: The same.
        fwd_actuation: The same.
        fwd_acceleration: The same.
        fwd_constraint: The same.
        sensor_acc: The same.
        euler: The same.
        timestep: The model's, as an array that shows it, s.
    """

    model: int
    data: int
    fwd_position: int
    fwd_velocity: int
    fwd_actuation: int
    fwd_acceleration: int
    fwd_constraint: int
    sensor_acc: int
    euler: int
    timestep: NDArray[np.float64]


def machine_of(model: mujoco.MjModel, data: mujoco.MjData) -> Machine:
    """The stages of a model; whoever has them keeps model and data alive.

    Raises:
        UnknownLayoutError: This MuJoCo is not understood.
    """
    at = layout()
    timestep = ctypes.cast(model._address + at.timestep, ctypes.POINTER(ctypes.c_double))
    return Machine(
        model=model._address,
        data=data._address,
        fwd_position=_address("mj_fwdPosition"),
        fwd_velocity=_address("mj_fwdVelocity"),
        fwd_actuation=_address("mj_fwdActuation"),
        fwd_acceleration=_address("mj_fwdAcceleration"),
        fwd_constraint=_address("mj_fwdConstraint"),
        sensor_acc=_address("mj_sensorAcc"),
        euler=_address("mj_Euler"),
        timestep=np.ctypeslib.as_array(timestep, (1,)),
    )


def _address(name: str) -> int:
    return ctypes.cast(getattr(library(), name), ctypes.c_void_p).value or 0


def position(machine: Machine) -> None:
    """As `mjbiped.engines.mujoco.kneed.stages.position`."""
    call_with(machine.fwd_position, machine.model, machine.data)


def velocity(machine: Machine) -> None:
    """As `mjbiped.engines.mujoco.kneed.stages.velocity`."""
    call_with(machine.fwd_velocity, machine.model, machine.data)


def forces(machine: Machine) -> None:
    """As `mjbiped.engines.mujoco.kneed.stages.forces`."""
    call_with(machine.fwd_actuation, machine.model, machine.data)
    call_with(machine.fwd_acceleration, machine.model, machine.data)
    call_with(machine.fwd_constraint, machine.model, machine.data)
    call_with(machine.sensor_acc, machine.model, machine.data)


def move(machine: Machine, length: float) -> None:
    """As `mjbiped.engines.mujoco.kneed.stages.move`."""
    machine.timestep[0] = length
    call_with(machine.euler, machine.model, machine.data)


STAGES = (position, velocity, forces, move)
"""In the order of `mjbiped.engines.mujoco.kneed.state.Parts`."""
