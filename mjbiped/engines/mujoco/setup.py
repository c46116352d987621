"""Setup of a walk in MuJoCo: its constants from its plan, its scene and the addresses of MuJoCo's memory."""

from __future__ import annotations

import cmath
import ctypes
import math
from dataclasses import replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from mjbiped.control.controller import Controller
from mjbiped.control.functions import acts_at_ticks, in_python
from mjbiped.disturbances.loop import SampledController
from mjbiped.engines.mujoco import feet, step_size
from mjbiped.engines.mujoco.collisions import ALL
from mjbiped.engines.mujoco.constants import Constants, Leg
from mjbiped.engines.mujoco.feet import for_feet
from mjbiped.engines.mujoco.ground import FOOT_RADIUS, Ground
from mjbiped.engines.mujoco.motors import SPARE
from mjbiped.engines.mujoco.options import MOTOR, Options, servo_of
from mjbiped.engines.mujoco.scene import MARGIN, GroundWindows, Scene
from mjbiped.engines.mujoco.state import SIZE, State
from mjbiped.engines.plan import DEFAULT_SAMPLE_PERIOD, Plan
from mjbiped.errors import MjbipedError
from mjbiped.records.columns import index_of, tables_of
from mjbiped.robots.bodies import Limb
from mjbiped.robots.robot import Robot
from mjbiped.rules.sole import servo_gains
from mjbiped.rules.termination import AVERAGED, FALLEN_HIP, STALL_TIME, SUSTAINED
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils import domains
from mjbiped.utils.mujoco import mujoco

_OF_DATA = ("qpos", "qvel", "qacc", "ctrl", "eq_active", "qacc_warmstart", "qfrc_applied", "sensordata")
_OF_MODEL = ("geom_contype", "geom_conaffinity", "geom_solref", "jnt_solref", "eq_solref", "eq_data")
_SIZES = ("nq", "nu", "ngeom", "njnt", "neq", "nsensordata")


def places_in(scene: Scene, terrain: Terrain, robot: Robot) -> dict[str, object]:
    """Where things are in a scene, as fields of `Constants`: ground, joints, geoms, and sensor data."""
    model, bodies, begin, stop = scene.model, robot.bodies, scene.pieces[0].segments[0], scene.pieces[-1].segments.stop
    shown = slice(begin, stop)
    x, z, gradient = map(np.array, terrain.profile[:3])
    grounds = [(model.geom(piece.name).id, piece.segments) for piece in scene.pieces for _ in piece.segments]
    geom, numbers = mujoco.mjtObj.mjOBJ_GEOM, range(begin, stop)
    return {
        "legs": [_leg_in(model, limb, robot) for limb in bodies.limbs],
        "leg_count": len(bodies.limbs),
        "order": [float(model.joint(name).qposadr[0]) for name in robot.places],
        "angles": len(robot.angles),
        "hip": mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, "hip"),
        "slots": int(model.sensor(f"{bodies.limbs[0].name}_contact").dim[0]),
        "x": x[shown].tolist(),
        # the centres of round feet meet the ground as points meet one that lies higher by their radius
        "z": (z[shown] + robot.radius * np.hypot(1.0, gradient[shown])).tolist(),
        "gradient": gradient[shown].tolist(),
        "segments": len(grounds),
        "rises": [float(rise) for rise in terrain.rises[shown]],
        "pieces": [float(geom) for geom, _ in grounds],
        "firsts": [float(piece[0] - begin) for _, piece in grounds],
        "lasts": [float(piece[-1] - begin) for _, piece in grounds],
        "risers": [float(mujoco.mj_name2id(model, geom, f"riser_{number}")) for number in numbers],
        "sills": [float(mujoco.mj_name2id(model, geom, f"sill_{number}")) for number in numbers],
    }


def _leg_in(model: mujoco.MjModel, limb: Limb, robot: Robot) -> Leg:
    """Where a leg's parts are in a model; of two segments the leg has a knee."""
    name, leg = limb.name, robot.bodies.leg
    lengths, turns = [segment.length for segment in leg], [segment.turn for segment in leg]
    lengths[-1] -= robot.radius  # down to the centre of a round foot
    foot, geoms = robot.bodies.foot, [int(model.geom(part).id) for part in robot.bodies.feet(limb)]
    straight = sum(length * cmath.exp(1j * turn) for length, turn in zip(lengths, turns, strict=True))
    sole = {"sole": -1, "toe": -1, "height": 0.0, "behind": 0.0, "ahead": 0.0}
    if foot is not None:
        sole = {"sole": int(model.joint(f"{name}_foot").qposadr[0]), "toe": geoms[1] if len(geoms) > 1 else -1}
        sole |= {"height": foot.height, "behind": foot.behind, "ahead": foot.ahead}
    knee = {"knee": -1, "stop": -1, "motor": -1, "lock": -1, "lower": 0.0, "bend": 0.0}
    if len(lengths) > 1:
        joint = model.joint(f"{name}_knee")
        knee = {"knee": int(joint.qposadr[0]), "stop": int(joint.id), "motor": int(model.actuator(f"{name}_knee").id)}
        knee |= {"lock": int(model.equality(f"{name}_lock").id), "lower": lengths[1], "bend": turns[1]}
    return Leg(
        hip=int(model.joint(limb.hinge).qposadr[0]),
        offset=limb.offset,
        lap=limb.lap,
        upper=lengths[0],
        foot=geoms[0],
        contacts=int(model.sensor(f"{name}_contact").adr[0]),
        ankle=int(model.actuator(limb.ankle).id),
        turn=turns[0],
        reach=abs(straight),
        **sole,
        **knee,
    )


def memory_in(scene: Scene, data: mujoco.MjData, touched: int, memory: int) -> dict[str, object]:
    """Arrays that show MuJoCo's memory, as fields of `Constants`.

    Args:
        scene: The robot on its ground.
        data: Of the scene's model.
        touched: Floats of a touchdown's row.
        memory: Floats of the controller's memory.
    """
    model, userdata, row, kinds = scene.model, data.userdata, SIZE + touched, data.warning.lastinfo
    return {
        "state": [State.from_buffer(userdata)],
        "whole": userdata[:row],
        "row": userdata[SIZE:row],
        "memory": userdata[row : row + memory],
        "rates": userdata[row + memory :],
        "time": _number_before(data, "time", data.energy),
        "timestep": _number_before(model.opt, "timestep", model.opt.gravity),
        "warnings": np.lib.stride_tricks.as_strided(kinds, (2 * len(kinds),), (kinds.itemsize,)),  # and their numbers
        **{name: getattr(data, name) for name in _OF_DATA},
        **{name: getattr(model, name).reshape(-1) for name in _OF_MODEL},
        **{name: getattr(model, name) for name in _SIZES},
    }


def _number_before(owner: object, name: str, array: NDArray[np.float64]) -> NDArray[np.float64]:
    """An array that shows a number which MuJoCo keeps a few places before an array.

    Raises:
        MjbipedError: This MuJoCo keeps it elsewhere.
    """
    value, mark, most = getattr(owner, name), 0.0123456789, 31
    shown = np.ctypeslib.as_array((ctypes.c_double * most).from_address(array.ctypes.data - 8 * most))
    setattr(owner, name, mark)
    places = np.flatnonzero(shown == mark)
    setattr(owner, name, value)
    if len(places) != 1:
        raise MjbipedError(f"MuJoCo {mujoco.__version__} keeps {name} elsewhere than expected: expected is 3 or 4")
    return shown[places[0] :][:1]


Buffers: TypeAlias = tuple[NDArray[np.float64], NDArray[np.float64]]
LONGEST_STEP = 1.0  # no step of a walk is longer, in leg lengths; decides how far the ground is built


def _shortest_step(options: Options) -> float:
    """Length of the physics steps that resolve impacts, s."""
    return min(options.contact_timestep, options.timestep) if options.lands else options.timestep


def settled(options: Options, plan: Plan) -> Options:
    """The engine's settings as a walk needs them."""
    foot, disturbances = plan.robot.bodies.foot, plan.disturbances
    if foot is not None:
        options = for_feet(options, foot)
    if disturbances.in_loop:
        options = replace(options, control_period=disturbances.period(options.control_period, options.timestep))
    return options


def windows_of(plan: Plan, options: Options, steps: int, *, userdata: int, scenery: bool) -> GroundWindows:
    """Scenes about any place of a walk; see `GroundWindows`.

    Args:
        plan: The walk.
        options: The engine's settings.
        steps: Physics steps between two moves of the window, at most.
        userdata: Number of floats in `mjData.userdata`.
        scenery: Whether to add the ground as it is seen from the side.
    """
    robot, terms = plan.robot, plan.terms
    way = steps * options.timestep * math.sqrt(robot.gravity * robot.leg_length)  # of the hip; a faster one would fly
    reach, margin = ground_needed(robot, terms.steps, terms.distance), MARGIN * robot.leg_length + way
    ground = Ground(plan.terrain, reach=reach, kind=options.ground)
    return GroundWindows(robot, ground, _shortest_step(options), margin, userdata, scenery)


def constants_of(
    plan: Plan, options: Options, controller: Controller, scene: Scene, data: mujoco.MjData, buffers: Buffers
) -> Constants:
    """The constants of a walk; its scene's model is changed to what the walk asks for.

    Args:
        plan: The walk.
        options: The engine's settings.
        controller: That of the robot's joints.
        scene: The robot on its ground.
        data: Of the scene's model.
        buffers: Room for samples and for touchdowns, shape (rows, columns) each.
    """
    model, period, (samples, rows) = scene.model, plan.terms.sample_period, buffers
    constants = Constants(
        **_walk_in(plan, options, controller),
        **places_in(scene, plan.terrain, plan.robot),
        **memory_in(scene, data, rows.shape[1], controller.memory_size),
        **in_python(controller)._asdict(),
        failed=[0.0],
        start=scene.start,
        end=scene.end,
        room=[0.0] * (len(controller.joints) + len(controller.states) + SPARE),
        # set even if no samples are kept: the last one tells where an interrupted walk stopped
        sample_period=DEFAULT_SAMPLE_PERIOD if period is None else period,
        samples=samples.reshape(-1),
        rows=rows.reshape(-1),
        sample_room=len(samples),
        row_room=len(rows),
        sample_width=samples.shape[1],
        row_width=rows.shape[1],
    )
    # nothing collides but what `collisions` says, or all the ground with feet that meet it as boxes
    model.geom_conaffinity[:] = 0
    if constants.box:
        model.geom_conaffinity[np.array(constants.pieces, dtype=int)] = ALL
    if plan.disturbances.friction is not None:  # the feet's friction has priority over the ground's
        feet = [geom for leg in constants.legs for geom in (leg.foot, leg.toe) if geom >= 0]
        model.geom_friction[feet, 0] = plan.disturbances.friction
    return constants


def _walk_in(plan: Plan, options: Options, controller: Controller) -> dict[str, object]:
    """What a walk's plan says, as fields of `Constants`; the controller is that of the robot's joints."""
    robot, terms, length, foot = plan.robot, plan.terms, plan.robot.leg_length, plan.robot.bodies.foot
    scuffs, shortest = not robot.collides_from_lift_off, _shortest_step(options)
    pendulum = math.sqrt(length / robot.gravity)
    # a foot with mass bounds no torque: it tips
    behind, ahead = (math.inf, math.inf) if robot.sole is None or foot is not None else robot.sole
    knee = servo_of(robot) if options.stance_knee == MOTOR else (0.0, 0.0)
    swing = (0.0, 0.0) if foot is None else servo_gains(foot.inertia, robot.leg_length, robot.gravity)
    return {
        "leg_length": length,
        "lowest_hip": FALLEN_HIP * length - robot.radius,  # the ground of round feet lies higher by their radius
        "foot_radius": FOOT_RADIUS,
        "rolling_radius": robot.radius + (0.0 if options.lands or foot is not None else FOOT_RADIUS),
        "weight": robot.weight,
        "reach": terms.scuffing.reach * length,
        "delay": float(terms.scuffing.delay),
        "stall_time": STALL_TIME * pendulum,
        "averaged": max(AVERAGED * pendulum, feet.FEWEST_AVERAGED * options.timestep),
        "airborne": feet.AIRBORNE * pendulum,
        "sustained": SUSTAINED * pendulum,
        "steps": math.inf if terms.steps is None else float(terms.steps),
        "distance": math.inf if terms.distance is None else float(terms.distance),
        "scuffs": scuffs,
        "stepped": bool(np.any(plan.terrain.rises)),
        # twice the path in a timestep after a fall through a leg length
        "deepest": 2.0 * options.timestep * math.sqrt(2.0 * robot.gravity * robot.leg_length),
        "longest": options.timestep,
        "shortest": shortest,
        "sliding": shortest if scuffs else max(options.timestep / step_size.SLIDING, shortest),
        "lands": options.lands,
        "radius": robot.radius,
        "feet": foot is not None,
        "box": foot is not None and foot.box,
        "behind": behind,
        "ahead": ahead,
        "knee_opens": robot.knee_opens,
        "knee_stiffness": knee[0],
        "knee_damping": knee[1],
        "foot_stiffness": swing[0],
        "foot_damping": swing[1],
        "control_period": options.control_period or 0.0,
        "memory_size": controller.memory_size,
        "states": len(controller.states),
        "sampled": isinstance(controller, SampledController),
        "ticks": isinstance(controller, SampledController) or acts_at_ticks(controller),
        "support": -1 if foot is None else controller.support,
        "pushes": [plan.disturbances.schedule],
        "estimate_at": index_of(tables_of(type(robot)).touchdowns, "slope_estimate_before"),
    }


def ground_needed(robot: Robot, steps: int | None, distance: float | None) -> float:
    """How far ahead of x = 0 a walk can come, m."""
    length = robot.leg_length
    ways = [steps * LONGEST_STEP * length] if steps is not None else []
    ways += [distance] if distance is not None else []
    return 2.0 * length + min(ways, default=domains.PLACE.high)  # no geom can be infinite
