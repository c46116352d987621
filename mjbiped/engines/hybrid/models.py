"""What the hybrid engine needs of each kind of robot."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from mjbiped.engines.hybrid import compass, kneed, kneed_posture
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot


class Model(NamedTuple):
    """A kind of robot in the hybrid engine.

    Attributes:
        functions: Those of `mjbiped.engines.hybrid.state.Laws` that are the robot's, in its order.
        constants: (robot, compiled) -> what they take of it, for compiled functions or in plain Python.
        write_state: The one of them that writes a sample.
        hot: Those that become part of the integrator's step where compiled.
        apart: What they call, and does not.
    """

    functions: tuple[Callable[..., Any], ...]
    constants: Callable[[Any, bool], Any]
    write_state: Callable[..., None]
    hot: tuple[Callable[..., Any], ...] = ()
    apart: tuple[Callable[..., Any], ...] = ()


_MODELS: Mapping[type[Robot], Model] = {
    Compass: Model(
        compass.MODEL,
        lambda robot, _: robot.constants,
        compass.write_state,
        hot=(compass.rates,),
        apart=(compass.on_face, compass.push_torque),
    ),
    KneedBiped: Model(kneed.MODEL, kneed_posture.constants_of, kneed.write_state),
}


def model_of(robot: Robot) -> Model:
    """The model of a robot."""
    return _MODELS[type(robot)]
