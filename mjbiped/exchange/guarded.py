"""Somebody's MJCF file, compiled by MuJoCo in a process of its own.

A model can crash MuJoCo's compiler, or keep it busy for hours; of memory it takes what the file asks for. So another
process compiles, within limits of time and memory, and sends the robot's parts.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mjbiped.errors import InputError, shortened
from mjbiped.exchange.parts import Part, check_lossless, parts_of
from mjbiped.utils.mujoco import mujoco

_LONGEST = 10  # s of processor time; a robot's model takes 0.4, nearly all of them for the import of MuJoCo
_PATIENCE = 60.0  # s on the clock, for what waits for a pipe, and for systems without such a limit
_MEMORY = 2 << 30  # bytes of address space; a robot's model takes 0.2 GiB, nearly all of them MuJoCo and NumPy
_ENDLESS = "has not come to an end"


class Compiled(NamedTuple):
    """What a compiled model holds.

    Attributes:
        parts: The moving parts, parents first.
        gravity: m/s^2.
        loss: What is said of a property that the robots of this package do not have; empty without one.
    """

    parts: list[Part]
    gravity: float
    loss: str


def compiled(path: Path) -> Compiled:
    """Compile an MJCF file in another process.

    Args:
        path: A regular file.

    Raises:
        InputError: MuJoCo cannot read it or fails on it, or its parts are not those of a
            planar robot; the message continues the file's name.
    """
    paths = [str(Path(each).absolute()) for each in sys.path]  # the same mjbiped
    threads = {"OPENBLAS_NUM_THREADS": "1"}  # the memory of others would count
    try:
        process = subprocess.run(
            [sys.executable, "-c", f"from {__name__} import main; main()", str(path), str(_LONGEST)],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths), **threads},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=_PATIENCE,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise _failure(_ENDLESS) from error
    if process.returncode:
        raise _failure(_reason(process))
    told = json.loads(process.stdout)
    if isinstance(told, str):
        raise InputError(told)
    parts, gravity, loss = told
    return Compiled([_part(*part) for part in parts], gravity, loss)


def _failure(words: str) -> InputError:
    return InputError(
        f"MuJoCo's compiler {words}, with {_LONGEST:g} s and {_MEMORY >> 30} GiB of memory; expected the model of "
        "a robot alone: remove other things, such as replicate, composite, flexcomp, attach, files and great sizes"
    )


def _reason(process: subprocess.CompletedProcess[str]) -> str:
    """How a process has ended: by its limit of time, by another signal, or with the last line that it said."""
    if process.returncode < 0:
        name = signal.Signals(-process.returncode).name
        return _ENDLESS if name == "SIGXCPU" else f"ends with {name}"
    return f"ends with {shortened((process.stderr.splitlines() or [f'status {process.returncode}'])[-1])}"


def _part(*values: object) -> Part:
    """A part whose vectors have come as lists."""
    part = Part(*values)  # type: ignore[arg-type]
    ends = tuple(np.array(end) for end in part.ends)
    return part._replace(anchor=np.array(part.anchor), centre=np.array(part.centre), ends=ends)


def main() -> None:
    """Compile a file, and print as JSON what it holds, or why it is refused.

    The command line names the file and the greatest processor time, s.
    """
    output = os.fdopen(os.dup(sys.stdout.fileno()), "w")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what MuJoCo prints is no JSON
    path, seconds = sys.argv[1], int(sys.argv[2])
    if sys.platform == "linux":  # others do not keep these limits
        import resource

        for kind, most in ((resource.RLIMIT_CPU, seconds), (resource.RLIMIT_AS, _MEMORY)):
            _, hard = resource.getrlimit(kind)
            resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))
    try:
        told: Compiled | str = _told(mujoco.MjModel.from_xml_path(path))
    except InputError as error:
        told = str(error)
    except ValueError as error:
        told = f"MuJoCo cannot read it: {shortened(' '.join(str(error).split()))}"
    with output:
        json.dump(told, output, default=np.ndarray.tolist)


def _told(model: mujoco.MjModel) -> Compiled:
    """What a model holds.

    Raises:
        InputError: Its parts are not those of a planar robot.
    """
    parts, loss = parts_of(model), ""
    try:
        check_lossless(model)
    except InputError as error:
        loss = str(error)
    return Compiled(parts, float(np.linalg.norm(model.opt.gravity)), loss)
