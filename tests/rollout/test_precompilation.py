"""Machine code made in advance: afterwards a walk compiles nothing."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from mjbiped.engines.compiling import VARIABLE

WALK = """
import sys
from numba.core import event
with event.install_recorder("numba:compile") as seen:
    from mjbiped.rollout.walk import _walk_a_step
    from mjbiped.robots.kinds import NAMED
    _walk_a_step((sys.argv[1], sys.argv[2], NAMED[sys.argv[3]]()))
print("compiled", *(each.data["dispatcher"].py_func.__name__ for _, each in seen.buffer))
"""


LONGEST = 900.0  # s; on a busy machine one law has taken 200


@pytest.mark.slow
@pytest.mark.parametrize(
    ("engine", "law", "robot"),
    [("mujoco", "kinetic-energy", "compass"), ("mujoco", "adaptive", "kneed"), ("hybrid", "adaptive", "kneed")],
)
def test_a_walk_after_it_compiles_nothing(engine: str, law: str, robot: str, tmp_path: Path) -> None:
    """With values of settings and a ground that it knew nothing of; processes at once share one folder."""

    def run(*words: str, folder: str = "made") -> subprocess.CompletedProcess[str]:
        environment = {**os.environ, VARIABLE: "always", "NUMBA_CACHE_DIR": str(tmp_path / folder), "COLUMNS": "200"}
        ran = subprocess.run([sys.executable, *words], env=environment, capture_output=True, text=True, timeout=LONGEST)
        assert ran.returncode == 0, ran.stderr
        return ran

    walked = ("-c", WALK, engine, law, robot)
    printed = run("-m", "mjbiped", "compile", law, "--engine", engine).stdout
    assert run(*walked).stdout == "compiled\n"
    if robot == "compass":
        assert printed.split() == ["compiled", "for", "the", engine, "engine:", law]
        assert "_torque" in run(*walked, folder="empty").stdout.split()  # the test can fail
        walk = ("walk", "random:seed=3", "--controller", law, "--gain", "gain=21", "--steps", "2")
        assert "compiling" not in run("-m", "mjbiped", *walk).stderr
