"""What mjbiped's own engine does beyond an exported scene, in words for the file's comment."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator

from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.terrain import Terrain
from mjbiped.version import __version__

_WIDTH = 110  # characters of a line


def notes_of(robot: Robot, terrain: Terrain, timestep: float) -> str:
    """Describe an exported scene.

    Args:
        robot: The robot.
        terrain: The ground.
        timestep: Length of the file's steps, s.
    """
    title = f"{robot.kind} on {terrain.caption}, written by mjbiped {__version__}. SI units and radians."
    start = (
        "It opens in plain MuJoCo with the robot upright. The keyframe START is the first state of a walk: in the "
        "viewer choose it under Simulation and press Load key; in Python call "
        'mujoco.mj_resetDataKeyframe(model, data, model.key("start").id).'
    ).replace("START", '"start"')
    lines = [title, start, "What mjbiped's own engine does beyond this file:"]
    lines += [f"* {note}" for note in _notes(robot, timestep)]
    lines = ["".join(letter for letter in line if letter.isprintable()) for line in lines]  # XML holds no others
    told = "\n".join(textwrap.fill(line, _WIDTH, initial_indent="    ", subsequent_indent="    ") for line in lines)
    return f"\n{told.replace('--', '- -')}\n  "  # no comment in XML holds two hyphens


def _notes(robot: Robot, timestep: float) -> Iterator[str]:
    """What the engine does, a sentence or two each."""
    yield (
        f"Steps: impacts are plastic because contacts are damped by 1/h for the timestep h = {timestep:g} s. With "
        "another timestep write -1/h into the second number of each solref (feet, risers, stops and locks of knees). "
        "The engine's own steps end at touchdowns, so that they can be longer."
    )
    yield (
        "Contact filter: a foot meets only the piece of ground under it and the riser beside it, never a corner; in "
        "the step of an impact the foot that departs passes through the ground."
    )
    reach = ScuffingRule().reach * robot.leg_length
    if not robot.collides_from_lift_off:
        yield (
            "Scuffing: straight legs of one length scuff at midstance, so a swing foot passes through the ground until "
            f"it is {reach:g} m ahead of the stance foot. This file says so for the first step alone: right_foot has "
            f"another contype, which only the ground from x = {reach:g} m on meets. To walk on, set model.geom_contype "
            "of a swing foot to 0 until it is ahead, and to 1 from then on."
        )
    else:
        yield (
            f"Lift-off: here the ground behind x = {-reach:g} m meets the first stance foot alone, by contype and "
            "conaffinity, so that the foot that departs at the start is not held."
        )
    if "knee" in robot.joints:
        yield (
            "Knees: the stance knee is locked, and the swing knee from its strike to the next lift-off, by the "
            "equalities left_lock and right_lock. Here left_lock is active. To walk on, switch data.eq_active at knee "
            "strikes and touchdowns."
        )
    yield (
        "Torques: this file has motors and no controller. An ankle's motor is an external torque on its leg; only that "
        "of the stance leg may act."
    )
    if robot.sole is not None:
        behind, ahead = robot.sole
        yield (
            f"Sole: it reaches {behind:g} m behind and {ahead:g} m ahead of the ankle, and is no geom here. The engine "
            "bounds the ankle's torque so that the centre of pressure stays on it."
        )
