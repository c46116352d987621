"""Somebody's MJCF file, compiled by MuJoCo in a process of its own.

A model can crash MuJoCo's compiler, or keep it busy for hours; of memory it takes what the file asks for. So another
process compiles, within limits of time and memory, and saves the compiled model.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from mjbiped.errors import InputError, shortened
from mjbiped.utils.mujoco import mujoco

_LONGEST = 10  # s of processor time; a robot's model takes 0.4, nearly all of them for the import of MuJoCo
_PATIENCE = 60.0  # s on the clock, for what waits for a pipe, and for systems without such a limit
_MEMORY = 2 << 30  # bytes of address space; a robot's model takes 0.2 GiB, nearly all of them MuJoCo and NumPy
_ENDLESS = "has not come to an end"
_UNREADABLE = 3  # exit status


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
        try:
            words = [sys.executable, "-c", f"from {__name__} import main; main()", str(path), saved, str(_LONGEST)]
            told: dict[str, Any] = {"stdin": subprocess.DEVNULL, "capture_output": True, "text": True}
            process = subprocess.run(words, env=env, timeout=_PATIENCE, errors="replace", check=False, **told)
        except subprocess.TimeoutExpired as error:
            raise _failure(_ENDLESS) from error
        if process.returncode == _UNREADABLE:
            raise InputError(f"MuJoCo cannot read it: {shortened(' '.join(process.stderr.split()))}")
        if process.returncode:
            raise _failure(_reason(process))
        return mujoco.MjModel.from_binary_path(saved)


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
