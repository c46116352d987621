"""Machine code: another for all that a function depends on, the bits of plain Python, and what is said of it."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest
from command_line import python

SETTINGS = """
import math

import numba
import numpy as np

from mjbiped.numerics.cache import announced
from mjbiped.numerics.machine import compiled

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

with announced("everything", 20.0):
    print(compiled(everything, "float64(float64)")(1.0), everything(1.0))
"""
SENTENCE = "compiling everything, once; it takes some 20 s ...\n"


def finished(folder: Path, cache: Path, *program: str) -> subprocess.CompletedProcess[str]:
    done = python(*program, cwd=folder, NUMBA_CACHE_DIR=str(cache))
    assert done.returncode == 0, done.stderr
    return done


@pytest.mark.slow
def test_whatever_a_function_depends_on_makes_it_another(tmp_path: Path) -> None:
    """Global tuples and arrays, functions compiled by their user, defaults, free variables."""
    cache, quiet = tmp_path / "cache", "from mjbiped.numerics.cache import announce\nannounce(wanted=False)\n"
    for changed in range(-1, 5):
        program = SETTINGS
        for index in range(5):
            program = program.replace(f"NUMBER_{index}", repr(2.0**index + 0.5 * (index == changed)))
        (tmp_path / "program.py").write_text(program, encoding="utf-8")
        first, again = (finished(tmp_path, cache, "program.py") for _ in range(2))
        assert (first.stderr, again.stderr) == (SENTENCE, "")
        compiled_one, plain = first.stdout.split()
        assert compiled_one == plain
        assert again.stdout == first.stdout
    (tmp_path / "program.py").write_text(quiet + program, encoding="utf-8")
    assert finished(tmp_path, tmp_path / "other", "program.py").stderr == ""  # where nobody wants it told


BITS = """
import json

import numba

from mjbiped.numerics.machine import compiled


def leaf(x, y):
    return x * y + 0.1 * x - y / 3.0


def middle(x, y):
    if x < 0.0:
        raise ValueError("x is negative")
    return leaf(x, y) * leaf(y, x) + leaf(x + y, x - y)


def root(x, y):
    return middle(x, y) - 0.7 * leaf(x, y)


@numba.njit
def users_inner(x):
    return 0.1 * x


@numba.njit
def users_outer(x, y):
    return middle(x, y) + users_inner(x)


made = compiled(root, "float64(float64, float64)")
pairs = [(0.1 * k, 1.7 - 0.3 * k) for k in range(20)]
found = {
    "compiled": [made(*pair).hex() for pair in pairs],
    "plain": [root(*pair).hex() for pair in pairs],
    "user's": [users_outer(*pair).hex() for pair in pairs],
    "user's, plain": [users_outer.py_func(*pair).hex() for pair in pairs],
}
try:
    made(-1.0, 1.0)
except ValueError as error:
    found["error"] = str(error)
symbols = next(iter(made.overloads.values())).library._codegen._engine._defined_symbols
found["emitted"] = [name for name in symbols if "leaf" in name and not name.startswith("_ZN08NumbaEnv")]
print(json.dumps(found))
"""


def test_machine_code_gives_the_bits_of_plain_python(tmp_path: Path) -> None:
    """Made and found on disk; functions of a user are compiled as ever, and may call ours."""
    (tmp_path / "program.py").write_text(BITS, encoding="utf-8")
    first, second = (json.loads(finished(tmp_path, tmp_path / "cache", "program.py").stdout) for _ in range(2))
    for found in (first, second):
        assert found["compiled"] == found["plain"]
        assert found["error"] == "x is negative"
        assert found["user's"] == found["user's, plain"]
    # fails with a release of Numba to which `machine` has to be fitted; results are the same there
    assert first["emitted"] == []  # but within its caller
