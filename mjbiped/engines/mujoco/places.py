"""Where things are in a scene and in MuJoCo's memory, as fields of `constants.Constants`."""

from __future__ import annotations

import cmath
import ctypes

import numpy as np
from numpy.typing import NDArray

from mjbiped.engines.mujoco.ground_window import Scene
from mjbiped.engines.mujoco.legs import Leg
from mjbiped.engines.mujoco.state import SIZE, State
from mjbiped.errors import MjbipedError
from mjbiped.robots.bodies import Limb
from mjbiped.robots.robot import Robot
from mjbiped.terrain.terrain import Terrain
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
