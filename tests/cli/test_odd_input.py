"""Words and files on a command line that nobody means: each is refused in a line, with status 2, and at once."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from command_line import run
from time_limits import within

from mjbiped.utils.files import LONGEST

LONGEST_WAIT = 20.0  # s; a moment's work, on a machine with other things to do
GREAT = "9" * 400


def sparse(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(8 << 30)


def brackets(path: Path) -> None:
    path.write_text("a = " + "[" * 100_000)


def no_text(path: Path) -> None:
    path.write_bytes(b"kind = '\xff'")


FILES: dict[str, tuple[Callable[[Path], object], str]] = {
    "sparse": (sparse, f"is longer than {LONGEST >> 20} MiB"),
    "pipe": (os.mkfifo, "is a device or a pipe"),
    "folder": (Path.mkdir, "is a folder"),
    "missing": (lambda _: None, "there is no such file"),
    "no_text": (no_text, "not UTF-8"),
    "brackets": (brackets, "nested too deeply"),
}
COMMANDS: dict[str, tuple[str, tuple[str, ...]]] = {
    "robot": (".toml", ("walk", "level", "--steps", "1", "--robot", "{}")),
    "terrain": (".toml", ("walk", "{}", "--steps", "1")),
    "study": (".toml", ("sweep", "{}")),
    "controller": (".py", ("walk", "level", "--steps", "1", "--controller", "{}:Law")),
}


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("kind", FILES)
def test_files_that_are_none(kind: str, command: str, tmp_path: Path) -> None:
    make, said = FILES[kind]
    suffix, words = COMMANDS[command]
    path = tmp_path / f"odd{suffix}"
    make(path)
    with within(LONGEST_WAIT, kind):
        result = run(*(word.format(path) for word in words))
    assert result.exit_code == 2
    if (kind, command) not in (("no_text", "controller"), ("brackets", "controller")):  # Python's own words
        assert said in result.stderr, result.stderr
    assert result.stderr.count("\n") < 6


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--disturb", f"delay={GREAT}"), "delay"),
        (("--disturb", f"seed={GREAT}"), "seed"),
        (("--gain", f"replanning_threshold={GREAT}"), "replanning_threshold"),
        (("--controller", "library", "--gain", f"climbing_steps={GREAT}"), "climbing_steps"),
        (("--steps", GREAT), "--steps"),
        (("--push", f"{GREAT}:1"), "--push"),
        (("--model-error", f"leg_mass={GREAT}"), "--model-error"),
        (("--reference", "clearance=10"), "clearance"),
        (("--reference", f"clearance={GREAT}"), "clearance"),
        (("--robot", "kneed", "--reference", "clearance=1.0"), "clearance"),
    ],
)
def test_numbers_that_no_walk_takes(words: tuple[str, ...], said: str) -> None:
    with within(LONGEST_WAIT, said):
        result = run("walk", "level", *words)
    assert result.exit_code == 2, result.stderr
    assert said in result.stderr
    assert "Traceback" not in result.stderr


@pytest.mark.slow
def test_files_may_have_names_that_are_no_utf8(tmp_path: Path) -> None:
    """As far as they are written, they are told of; where the system has such names."""
    name = os.fsdecode(b"w\xff.npz")
    try:
        (tmp_path / name).touch()
    except OSError:
        pytest.skip("no such names here")
    words = ("walk", "level", "--engine", "hybrid", "--steps", "1", "--out", name)
    done = subprocess.run(
        [sys.executable, "-m", "mjbiped", *words],
        cwd=tmp_path,
        capture_output=True,
        env={**os.environ, "PYTHONIOENCODING": "utf-8", "PYTHONPATH": os.pathsep.join(sys.path)},
        check=False,
        timeout=120,
    )
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"w" in done.stdout
    assert (tmp_path / name).stat().st_size > 1000
    odd = os.fsdecode(b"\xff")
    (tmp_path / f"{odd}.csv").write_text("0,0\n9,0\n")
    (tmp_path / f"{odd}.py").write_text("")
    grounds: tuple[tuple[str, ...], ...] = (
        (str(tmp_path / f"{odd}.csv"),),
        ("level", "--controller", f"{tmp_path / odd}.py:Law"),
    )
    for ground in grounds:
        refused = run("walk", *ground)
        assert (refused.exit_code, "must be text that UTF-8 can write" in refused.stderr) == (2, True), refused.stderr
