"""Compilation: what one program keeps on disk does not hinder another."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

COMMON = """
from typing import Any, NamedTuple
from mjbiped.numerics.jit import compiled

class Group(NamedTuple):
    inner: Any

def twice(x):
    return 2.0 * x

def outer(group, x, y, z):
    return group.inner(x[0]) + y + z
"""
MINE = (
    COMMON
    + """
class Gains(NamedTuple):
    stiffness: float

if __name__ != "__main__":
    print(compiled(outer, Group, (twice,), ())(Gains(3.0), 1.0, 1.0))
"""
)
YOURS = (
    COMMON.replace("2.0 * x", "3.0 * x")
    + """
print(compiled(outer, Group, (twice,), ())((3.0,), 1.0, 1.0))
"""
)

TWO_LAYERS = (
    COMMON
    + """
def around(group, x, y, z):
    return group.inner(x, y, z) - 1.0

inner = compiled(outer, Group, (twice,), ())
print(compiled(around, Group, (inner,), ())((3.0,), 1.0, 1.0), inner((3.0,), 1.0, 1.0))
"""
)

ANNOUNCED = (
    COMMON
    + """
from mjbiped.numerics.jit import announce, announced
announce(wanted={wanted})
with announced("everything", 20.0):
    compiled(outer, Group, (twice,), ())((3.0,), 1.0, 1.0)
compiled(outer, Group, (twice,), ())((3,), 1.0, 1.0)  # of another type, so compiled again, and nobody waits for it
"""
)
SENTENCE = "compiling everything, once; it takes some 20 s ...\n"


def run(folder: Path, cache: Path, program: str) -> str:
    return finished(folder, cache, program).stdout.strip()


def finished(folder: Path, cache: Path, program: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": f"{Path(__file__).parents[2]}"}
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done


@pytest.mark.slow
def test_types_of_one_program_do_not_keep_another_from_its_cache(tmp_path: Path) -> None:
    """A NamedTuple of a user's module was listed among what all programs read, who then failed to import it."""
    mine, yours, cache = tmp_path / "mine", tmp_path / "yours", tmp_path / "cache"
    for folder in (mine, yours):
        folder.mkdir()
    (mine / "my_controller.py").write_text(MINE, encoding="utf-8")
    (yours / "your_controller.py").write_text(YOURS, encoding="utf-8")
    assert run(mine, cache, "import my_controller") == "8.0"
    kept = set(cache.rglob("*.nbc"))
    assert kept
    assert run(yours, cache, "import your_controller") == "11.0"
    before = {path: path.stat().st_mtime_ns for path in cache.rglob("*.nb?")}
    assert run(mine, cache, "import my_controller") == "8.0"  # from the cache: nothing is written
    assert {path: path.stat().st_mtime_ns for path in cache.rglob("*.nb?")} == before


@pytest.mark.slow
def test_machine_code_is_called_by_other_machine_code_and_both_are_kept(tmp_path: Path) -> None:
    """A change in the inner one is one of the outer one, too, which has its machine code in it."""
    cache = tmp_path / "cache"
    for name, factor, results in (("two", "2.0", "7.0 8.0"), ("three", "3.0", "10.0 11.0")):
        (tmp_path / f"{name}.py").write_text(TWO_LAYERS.replace("2.0", factor), encoding="utf-8")
        assert run(tmp_path, cache, f"import {name}") == results
        before = {path: path.stat().st_mtime_ns for path in cache.rglob("*.nb?")}
        assert run(tmp_path, cache, f"import {name}") == results
        assert {path: path.stat().st_mtime_ns for path in cache.rglob("*.nb?")} == before
    assert len(list(cache.rglob("*.nbc"))) == 4


@pytest.mark.slow
def test_only_what_is_not_on_disk_is_announced(tmp_path: Path) -> None:
    for name, wanted in (("told", "True"), ("quiet", "False")):
        (tmp_path / f"{name}.py").write_text(ANNOUNCED.replace("{wanted}", wanted), encoding="utf-8")
    runs = (("a", "told"), ("a", "told"), ("b", "quiet"))
    said = [finished(tmp_path, tmp_path / cache, f"import {name}").stderr for cache, name in runs]
    assert said == [SENTENCE, "", ""]


@pytest.mark.slow
@pytest.mark.compiled
@pytest.mark.parametrize("engine", ["mujoco", "hybrid"])
def test_the_first_walk_says_what_it_waits_for(engine: str, tmp_path: Path) -> None:
    program = f"""
import mjbiped.cli.main
mjbiped.cli.main.main(["walk", "incline:slope_deg=2", "--controller", "passive", "--steps", "1", "--engine",
"{engine}"])
"""
    first, second = (finished(tmp_path, tmp_path / "cache", program).stderr for _ in range(2))
    sentence, *progress = first.splitlines()
    words = rf"compiling PassiveController for the engine {engine}, once; it takes some \d+ s \.\.\."
    assert re.fullmatch(words, sentence)
    assert all(line.startswith("walking: ") for line in progress)  # on a machine that takes longer
    assert second == ""


SETTINGS = """
import math
import sys

import numba
import numpy as np

from mjbiped.numerics.jit import jitted, prepared, renamed

PAIR = (1.0, NUMBER_0)
TABLE = np.array([0.0, NUMBER_1])

@numba.njit
def compiled_by_its_user(x):
    return NUMBER_2 * x

def with_default(x, factor=NUMBER_3):
    return factor * x

def within(factor):
    def product(x):
        return factor * with_default(x)
    return product

product = within(NUMBER_4)

def everything(x):
    return PAIR[1] * x + TABLE[1] * x + compiled_by_its_user(x) + with_default(x) + product(x) + 0.0 * math.sin(x)

made = jitted(renamed(everything, f"everything_{prepared((everything,), ())[:16]}"), _nrt=False)

@numba.njit
def call(x):
    return made(x)

print(call(1.0), everything(1.0))
"""


@pytest.mark.slow
def test_whatever_a_function_depends_on_makes_it_another(tmp_path: Path) -> None:
    """Global tuples and arrays, functions compiled by their user, defaults, free variables."""
    cache = tmp_path / "cache"
    for changed in range(-1, 5):
        program = SETTINGS
        for index in range(5):
            program = program.replace(f"NUMBER_{index}", repr(2.0**index + 0.5 * (index == changed)))
        (tmp_path / "program.py").write_text(program, encoding="utf-8")
        compiled_one, plain = run(tmp_path, cache, "import program").split()
        assert compiled_one == plain
        before = set(cache.rglob("*.nbc"))
        assert run(tmp_path, cache, "import program").split() == [compiled_one, plain]
        assert set(cache.rglob("*.nbc")) == before
