"""Machine code kept for one user's law is no obstacle to programs that do not know that user's modules."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import own_controllers
import pytest

from mjbiped.control.controller import never
from mjbiped.numerics.jit import kept_apart

LAW = """\
import math
from typing import NamedTuple

import mjbiped
from controllers import Controller
from mjbiped.control.controller import Law, never


class Parameters(NamedTuple):
    stiffness: float


def spring(parameters, memory, t, q1, q2, dq1, dq2):
    return 0.0, -parameters.stiffness * (q2 - q1 - 0.4)


def nothing(parameters, memory, q1_before, q2_before, q1, q2, dq1, dq2):
    pass


def no_estimate(parameters, memory):
    return math.nan


class Spring(Controller):
    def torque(self, memory, t, q, dq):
        return spring(Parameters(0.5), memory, t, *q, *dq)

    def law(self):
        return Law(Parameters(0.5), spring, nothing, no_estimate, never)
"""

PROGRAM = """\
from mjbiped.control.compilation import MachineCode
from {module} import Spring

print(MachineCode(Spring().law(), 0, 0).failed)
"""


def test_types_that_not_every_program_knows_have_names_of_their_own() -> None:
    names = {kept_apart(never, types)[0].__name__ for types in ((), ("first.Parameters",), ("second.Parameters",))}
    assert len(names) == 3


@pytest.mark.slow
def test_two_programs_keep_the_same_function_for_types_of_their_own(tmp_path: Path) -> None:
    """`never`, which both take from the project, for `Parameters` of modules that the other one does not have."""
    for module in ("first_law", "second_law"):
        folder = tmp_path / module
        own_controllers.write(folder, f"{module}.py", LAW)
        own_controllers.write(folder, "program.py", PROGRAM.format(module=module))
        environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
        done = subprocess.run(
            [sys.executable, "program.py"], cwd=folder, env=environment, capture_output=True, text=True, timeout=120
        )
        assert (done.stdout, done.stderr) == ("False\n", "")
