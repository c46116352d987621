"""Checks of the objects that a user gives for walks: robots, controllers, grounds and scuffing rules."""

from __future__ import annotations

from mjbiped.control.controller import Controller
from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.errors import InputError, MjbipedError, explained, place_of, shown
from mjbiped.gaits.gait import Gait
from mjbiped.records.schema import described
from mjbiped.robots.kinds import KINDS
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.domains import Count


def check_rule(robot: Robot, rule: ScuffingRule) -> None:
    """Refuse a scuffing rule for a robot whose swing foot collides with the ground at all times.

    Raises:
        InputError: The rule is not the default one.
    """
    if robot.collides_from_lift_off and rule != ScuffingRule():
        raise InputError(
            f"scuffing is for straight legs: a {type(robot).__name__} needs none, its swing foot's contact is on "
            "from lift-off; leave the rule out"
        )


def check_ground(robot: Robot, terrain: Terrain) -> None:
    """Refuse ground that a robot cannot stand on: uneven under round feet, and no profile under a planar robot.

    Raises:
        InputError: A round foot would touch in two places at once, or a planar robot would fall to one side.
    """
    if not terrain.is_profile and "hip_y" not in robot.places:
        raise InputError(
            f"a {type(robot).__name__} moves in a plane and walks on profiles, and the ground {shown(terrain.name)} "
            "is not the same at all y; walk it with a mjbiped.Compass3D or a mjbiped.Kneed3D (--robot compass3d, "
            "kneed3d), or choose ground that is level across"
        )
    if robot.radius and (any(terrain.rises) or len(set(terrain.angle)) > 1):
        raise InputError(
            f"a {type(robot).__name__} walks on planes, for on uneven ground a round foot would touch in two places at "
            "once: choose level ground or an incline"
        )


def check_disturbed(robot: Robot, disturbances: Disturbances) -> None:
    """Refuse pushes across the walking direction of a planar robot, and loops of a robot in space.

    Raises:
        InputError: The disturbances are not for such a robot.
    """
    in_space, name = "hip_y" in robot.places, type(robot).__name__
    if disturbances.push_direction and not in_space:
        raise InputError(
            f"push_direction = {disturbances.push_direction:g}: a {name} moves in a plane and is pushed forward or "
            "backward; leave push_direction out, or walk a mjbiped.Compass3D or a mjbiped.Kneed3D"
        )
    if disturbances.in_loop and in_space:
        raise InputError(
            f"a {name} is disturbed by pushes and friction alone, so far; leave noise, delay and limits of motors out"
        )


def check_robot(name: str, robot: object) -> None:
    """Refuse an object that is no robot.

    Raises:
        InputError: The object is no robot.
    """
    if not isinstance(robot, Robot):
        raise InputError(
            f"{name} must be a mjbiped.{' or a mjbiped.'.join(kind.__name__ for kind in KINDS.values())}, got "
            f"{shown(robot) if isinstance(robot, str) else type(robot).__name__}"
        )


def check_controller(controller: object) -> dict[str, object]:
    """Refuse an object that is no controller, and return a controller's description.

    Raises:
        InputError: The object is no controller, or one of its attributes fails or has the wrong type.
    """
    if not isinstance(controller, Controller):
        what = "is a class, not an object of it" if isinstance(controller, type) else "is none"
        raise InputError(f"the controller {shown(controller)} {what}; derive your class from controllers.Controller")
    try:
        return _checked_parts(controller)
    except MjbipedError:
        raise
    except (Exception, SystemExit) as error:  # properties and `describe` are the user's code, which may raise anything
        kind = type(controller)
        raise InputError(
            f"{kind.__name__} does not tell what it is: {explained(error)}{place_of(error, kind)}"
        ) from error


def _checked_parts(controller: Controller) -> dict[str, object]:
    name = type(controller).__name__
    states: object = controller.states
    if not isinstance(states, tuple | list) or not all(isinstance(state, str) for state in states):
        raise InputError(f"{name}.states = {shown(states)}: must be a tuple of names")
    if Count(0, 10_000).check(f"{name}.memory_size", controller.memory_size) < len(states):
        raise InputError(f"{name}.memory_size = {controller.memory_size}: must be at least its {len(states)} states")
    places, last = controller.support, controller.memory_size - 2
    if places != -1 and not (isinstance(places, int) and len(states) <= places <= last):
        raise InputError(
            f"{name}.support = {shown(places)}: must be -1, or the index of the first of two numbers in the memory "
            f"behind its {len(states)} states, {last} at most; memory_size is {controller.memory_size}"
        )
    if controller.robot is not None:
        check_robot(f"{name}.robot", controller.robot)
    if not isinstance(controller.gait, Gait | None):
        raise InputError(
            f"{name}.gait is of type {type(controller.gait).__name__}; must be a gait that find_passive_gait, "
            "find_kneed_gait or find_reference gives"
        )
    try:
        return described(controller.describe())
    except ValueError as error:
        raise InputError(
            f"{name}.describe() must give what a record can hold and tell again, a table of plain JSON types with a "
            f"name: {error}"
        ) from error
