"""The stages of a physics step with knees, as MuJoCo's Python package has them; see `state.Parts`."""

from __future__ import annotations

from typing import NamedTuple

import mujoco


class Machine(NamedTuple):
    """What the stages are called with.

    Attributes:
        model: MuJoCo's.
        data: Its state.
    """

    model: mujoco.MjModel
    data: mujoco.MjData


def position(machine: Machine) -> None:
    """Contacts and constraints are made."""
    mujoco.mj_fwdPosition(machine.model, machine.data)


def velocity(machine: Machine) -> None:
    """What depends on rates."""
    mujoco.mj_fwdVelocity(machine.model, machine.data)


def forces(machine: Machine) -> None:
    """Motors, accelerations, constraint forces, and the sensors that show them."""
    mujoco.mj_fwdActuation(machine.model, machine.data)
    mujoco.mj_fwdAcceleration(machine.model, machine.data)
    mujoco.mj_fwdConstraint(machine.model, machine.data)
    mujoco.mj_sensorAcc(machine.model, machine.data)


def move(machine: Machine, length: float) -> None:
    """The state goes on by a time in s."""
    machine.model.opt.timestep = length
    mujoco.mj_Euler(machine.model, machine.data)


STAGES = (position, velocity, forces, move)
"""In the order of `state.Parts`."""
