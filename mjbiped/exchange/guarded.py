"""Somebody's MJCF file, compiled by MuJoCo in a process of its own.

A model can crash MuJoCo's compiler, or keep it busy for hours; of memory it takes what the file asks for. So another
process compiles, within limits of time and memory, and sends the robot's parts.
"""

from __future__ import annotations

import json
import os
import signal
import stat
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from mjbiped.errors import InputError, shortened, shown
from mjbiped.exchange.parts import Part, check_lossless, parts_of
from mjbiped.utils.mujoco import mujoco
from mjbiped.utils.reading import read_bytes

_LONGEST = 10  # s of processor time; a robot's model takes 0.4, nearly all of them for the import of MuJoCo
_PATIENCE = 60.0  # s on the clock, for what waits, and for systems without such a limit
_MEMORY = 2 << 30  # bytes of address space; a robot's model takes 0.2 GiB, nearly all of them MuJoCo and NumPy
_ENDLESS = "has not come to an end"
_OF_MJCF = ("include", "model")  # elements that name other MJCF files
_FOLDERS = ("assetdir", "meshdir", "texturedir")


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
        InputError: It names what is no file, MuJoCo cannot read it or fails on it, or its parts are not those of a
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


def _check_files(path: Path) -> None:
    """Refuse an MJCF file that names pipes or devices, directly or in another MJCF file: MuJoCo would wait for them.

    Raises:
        InputError: It does, or an MJCF file is very long.
    """
    files, roots = [path], []
    for file in files:  # it grows by those that a file names
        try:
            roots.append(ElementTree.fromstring(read_bytes(file)))
        except (ElementTree.ParseError, ValueError, LookupError) as error:
            if isinstance(error, InputError):
                raise
            continue  # MuJoCo says what is wrong
        named = {each.get("file", "") for tag in _OF_MJCF for each in roots[-1].iter(tag)}
        files += _files_named(named, {path.parent, file.parent}).difference(files)
    elements = [element for root in roots for element in root.iter()]
    folders = {element.get(key, "") for element in elements for key in _FOLDERS}
    named = {value for element in elements for key, value in element.items() if key.startswith("file")}
    _files_named(named, {file.parent / folder for file in files for folder in ("", *folders)})


def _files_named(names: set[str], folders: set[Path]) -> set[Path]:
    """Return the regular files of these names in these folders.

    Raises:
        InputError: One is a pipe or a device.
    """
    files = set()
    for place, name in ((folder / name, name) for folder in folders for name in names):
        try:
            kind = place.stat().st_mode
        except (OSError, ValueError):
            continue  # it is in another folder, or MuJoCo says that it is missing
        if stat.S_ISREG(kind):
            files.add(place)
        elif not stat.S_ISDIR(kind):
            raise InputError(f"it names {shown(name)}, which is a device or a pipe; expected a file")
    return files


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
        _check_files(Path(path))
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
