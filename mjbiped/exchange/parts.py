"""The moving parts of a planar robot in a user's MuJoCo model, seen in its plane.

A model can crash MuJoCo's compiler, keep it busy for hours, or exhaust the memory. So another process compiles, within
limits of time and memory, and saves the compiled model.
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjbiped.errors import InputError, shortened
from mjbiped.utils.mujoco import mujoco

_LONGEST = 10  # s of processor time; a robot's model takes 0.4, nearly all of them for the import of MuJoCo
_PATIENCE = 60.0  # s on the clock, for what waits for a pipe, and for systems without such a limit
_MEMORY = 2 << 30  # bytes of address space; a robot's model takes 0.2 GiB, nearly all of them MuJoCo and NumPy
_UNREADABLE = 3  # exit status
_TOO_LATE = -getattr(signal, "SIGXCPU", 1000)  # status after the limit of time


def compiled(path: Path) -> mujoco.MjModel:
    """Compile an MJCF file in another process.

    Args:
        path: A regular file.

    Raises:
        InputError: MuJoCo cannot read it or fails on it; the message continues the file's name.
    """
    paths = [str(Path(each).absolute()) for each in sys.path]  # the same mjbiped
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "OPENBLAS_NUM_THREADS": "1"}  # threads take memory too
    with tempfile.TemporaryDirectory() as folder:
        saved = str(Path(folder) / "model.mjb")
        words = [sys.executable, "-c", f"from {__name__} import main; main()", str(path), saved, str(_LONGEST)]
        told: dict[str, Any] = {"stdin": subprocess.DEVNULL, "capture_output": True, "text": True, "errors": "replace"}
        try:
            process = subprocess.run(words, env=env, timeout=_PATIENCE, check=False, **told)
            status, said = process.returncode, process.stderr
        except subprocess.TimeoutExpired:
            status, said = _TOO_LATE, ""
        if status == 0:
            return mujoco.MjModel.from_binary_path(saved)
    if status == _UNREADABLE:
        raise InputError(f"MuJoCo cannot read it: {shortened(' '.join(said.split()))}")
    if status == _TOO_LATE:
        ended = "has not come to an end"
    elif status < 0:
        ended = f"ends with {signal.Signals(-status).name}"
    else:
        ended = f"ends with {shortened((said.splitlines() or [f'status {status}'])[-1])}"
    raise InputError(
        f"MuJoCo's compiler {ended}, with {_LONGEST:g} s and {_MEMORY >> 30} GiB of memory; expected the model of "
        "a robot alone: remove other things, such as replicate, composite, flexcomp, attach, files and great sizes"
    )


def main() -> None:
    """Compile a file, and save the model.

    The command line names both files, and the greatest processor time, s.
    """
    path, saved, seconds = sys.argv[1:]
    if sys.platform == "linux":  # others do not keep these limits
        import resource

        for kind, most in ((resource.RLIMIT_CPU, int(seconds)), (resource.RLIMIT_AS, _MEMORY)):
            _, hard = resource.getrlimit(kind)
            resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))
    try:
        model = mujoco.MjModel.from_xml_path(path)
    except ValueError as error:
        print(error, file=sys.stderr)
        sys.exit(_UNREADABLE)
    mujoco.MjData(model)  # whose memory counts too
    mujoco.mj_saveModel(model, saved, None)


Vector = NDArray[np.float64]

_LOSSES = "dof_damping dof_armature dof_frictionloss jnt_stiffness tendon_damping tendon_stiffness body_gravcomp"
_PARALLEL = 1e-6  # greatest sine of the angle between directions that count as one
_SPHERE, _CAPSULE = int(mujoco.mjtGeom.mjGEOM_SPHERE), int(mujoco.mjtGeom.mjGEOM_CAPSULE)
_HINGE, _SLIDE = int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)


class Part(NamedTuple):
    """Bodies that are welded together and move as one, in the model's reference posture.

    Attributes:
        name: Name of its first body.
        parent: Number of the part that holds it; -1: the world.
        turns: Whether it turns against what holds it.
        anchor: Place of the hinge that holds it, shape (2,), m; without a hinge its body's origin.
        mass: kg.
        centre: Place of its centre of mass, shape (2,), m.
        inertia: About its centre of mass and the hinges' axis, kg m^2.
        ends: Places of the spheres and of the ends of the capsules that can touch something, each of shape (2,), m.
    """

    name: str
    parent: int
    turns: bool
    anchor: Vector
    mass: float
    centre: Vector
    inertia: float
    ends: tuple[Vector, ...]


def parts_of(model: mujoco.MjModel) -> list[Part]:
    """Return the moving parts, parents first.

    Raises:
        InputError: They are not those of a planar robot; the message continues the model's name.
    """
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    firsts = sorted({int(weld) for weld in model.body_weldid if weld})
    if not firsts:
        raise InputError("nothing in it moves; expected a robot whose bodies have joints")
    plane, axis = _plane_of(model, data)
    for first in firsts:
        _check_joints(model, data, first, axis)
    return [_part(model, data, first, firsts, plane, axis) for first in firsts]


def check_lossless(model: mujoco.MjModel) -> None:
    """Refuse what the robots of this package do not have.

    Raises:
        InputError: A joint or tendon has it.
    """
    for name in _LOSSES.split():
        values = getattr(model, name)
        if np.any(values):
            said = re.sub("^(dof|jnt|body)_", "", name).replace("_", " ")
            raise InputError(
                f"it has {said} ({np.max(values):g}), which the robots here have not; set it to 0 in a copy"
            )


def limits_of(model: mujoco.MjModel) -> dict[str, float]:
    """Greatest torques that the file lets hinges and motors have, N m, by their names; others are not bounded.

    Of a motor the least bound counts: that of its force, and of its control where torque is proportional to control.
    """
    hinges = [each for each in np.flatnonzero(model.jnt_actfrclimited) if model.jnt_type[each] == _HINGE]
    found = {f"hinge {_joint(model, int(each))}": _greatest(model.jnt_actfrcrange[each]) for each in hinges}
    for motor in range(model.nu):
        bounds, gear = [], model.actuator_gear[motor, 0]
        if model.actuator_forcelimited[motor]:
            bounds.append(_greatest(gear * model.actuator_forcerange[motor]))
        if model.actuator_ctrllimited[motor] and not model.actuator_biastype[motor]:
            gain = model.actuator_gainprm[motor, 0]
            bounds.append(_greatest(gear * gain * model.actuator_ctrlrange[motor]))
        if bounds:
            found[f"motor {model.actuator(motor).name or motor}"] = min(bounds)
    return found


def _greatest(ends: Vector) -> float:
    return float(np.abs(ends).max())


def _plane_of(model: mujoco.MjModel, data: mujoco.MjData) -> tuple[Vector, Vector]:
    """Return the directions forward and up as rows, shape (2, 3), and the axis of the hinges, shape (3,).

    Raises:
        InputError: There are no hinges or no gravity, or the hinges are not horizontal.
    """
    hinges, gravity = np.flatnonzero(model.jnt_type == _HINGE), float(np.linalg.norm(model.opt.gravity))
    if not len(hinges):
        raise InputError("it has no hinges; expected a hip")
    if not gravity:
        raise InputError("it has no gravity; expected option gravity downwards")
    up, axis = -model.opt.gravity / gravity, data.xaxis[hinges[-1]].copy()
    if abs(up @ axis) > _PARALLEL:
        raise InputError(
            f"the hinge {_joint(model, hinges[-1])} is not horizontal; expected a robot that moves in a plane"
        )
    return np.array([np.cross(axis, up), up]), axis


def _check_joints(model: mujoco.MjModel, data: mujoco.MjData, first: int, axis: Vector) -> None:
    """Refuse joints that lead out of the plane, and parts that hang on others by anything but a hinge.

    Raises:
        InputError: The part of the body `first` is held by such joints.
    """
    joints, name, hinges = _joints(model, first), _body(model, first), 0
    for joint in joints:
        kind, along = model.jnt_type[joint], abs(float(data.xaxis[joint] @ axis))
        if kind not in (_HINGE, _SLIDE):
            raise InputError(f"{name} has a free or ball joint; expected slides and hinges, which keep it in a plane")
        if (kind == _HINGE and along < 1.0 - _PARALLEL) or (kind == _SLIDE and along > _PARALLEL):
            raise InputError(f"the joint {_joint(model, joint)} leads out of the plane of the others; remove it")
        hinges += kind == _HINGE
    root = model.body_weldid[model.body_parentid[first]] == 0
    if hinges > 1 or not (root or len(joints) == hinges == 1):
        expected = "slides, and one hinge at most" if root else "one hinge"
        raise InputError(f"{name} is held by {len(joints)} joints, {hinges} of them hinges; expected {expected}")


def _joints(model: mujoco.MjModel, body: int) -> range:
    """Numbers of a body's joints."""
    start = int(model.body_jntadr[body])
    return range(start, start + int(model.body_jntnum[body]))


def _part(
    model: mujoco.MjModel, data: mujoco.MjData, first: int, firsts: list[int], plane: Vector, axis: Vector
) -> Part:
    """Gather what is welded to the body `first`."""
    bodies = np.flatnonzero(model.body_weldid == first)
    masses, places = model.body_mass[bodies], data.xipos[bodies] @ plane.T
    mass = float(masses.sum())
    centre = masses @ places / mass
    across = data.ximat[bodies].reshape(-1, 3, 3).transpose(0, 2, 1) @ axis  # the axis in each body's inertial frame
    own = (model.body_inertia[bodies] * across**2).sum()
    inertia = own + masses @ ((places - centre) ** 2).sum(axis=1)
    hinges = [joint for joint in _joints(model, first) if model.jnt_type[joint] == _HINGE]
    parent = int(model.body_weldid[model.body_parentid[first]])
    return Part(
        name=_body(model, first),
        parent=firsts.index(parent) if parent else -1,
        turns=bool(hinges),
        anchor=plane @ (data.xanchor[hinges[0]] if hinges else data.xpos[first]),
        mass=mass,
        centre=centre,
        inertia=float(inertia),
        ends=tuple(plane @ end for body in bodies for end in _ends(model, data, int(body))),
    )


def _ends(model: mujoco.MjModel, data: mujoco.MjData, body: int) -> Iterator[Vector]:
    """Yield centres of the spheres and ends of the capsules' axes of a body that can touch something, shape (3,), m."""
    for geom in np.flatnonzero(model.geom_bodyid == body):
        if model.geom_contype[geom] or model.geom_conaffinity[geom]:
            half = data.geom_xmat[geom].reshape(3, 3)[:, 2] * model.geom_size[geom, 1]
            if model.geom_type[geom] == _SPHERE:
                yield data.geom_xpos[geom]
            elif model.geom_type[geom] == _CAPSULE:
                yield from (data.geom_xpos[geom] - half, data.geom_xpos[geom] + half)


def _body(model: mujoco.MjModel, body: int) -> str:
    return f"the body {model.body(body).name!r}" if model.body(body).name else f"body {body}, which has no name,"


def _joint(model: mujoco.MjModel, joint: int) -> str:
    return repr(model.joint(joint).name) if model.joint(joint).name else f"number {joint}"
