"""Machine code made in advance: afterwards a walk compiles nothing."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from mjbiped.engines.compiling import VARIABLE
from mjbiped.errors import InputError
from mjbiped.rollout.walk import precompile

WALK = """
import sys
from numba.core import event

class Compiling(event.Listener):
    def on_start(self, event):
        print("compiled", event.data["dispatcher"].py_func.__name__)
    def on_end(self, event):
        pass

event.register("numba:compile", Compiling())
from mjbiped.rollout.walk import _walk_a_step
from mjbiped.robots.kinds import NAMED
_walk_a_step((sys.argv[1], sys.argv[2], NAMED[sys.argv[3]]()))
print("walked")
"""


LONGEST = 900.0  # s; on a busy machine one law has taken 200


@pytest.mark.slow
def test_a_walk_after_it_compiles_nothing(tmp_path: Path) -> None:
    """With values of settings and a ground that it knew nothing of; processes at once share one folder."""

    def run(*words: str, folder: str = "made") -> subprocess.CompletedProcess[str]:
        environment = {**os.environ, VARIABLE: "always", "NUMBA_CACHE_DIR": str(tmp_path / folder), "COLUMNS": "200"}
        done = subprocess.run(
            [sys.executable, *words], env=environment, capture_output=True, text=True, timeout=LONGEST
        )
        assert done.returncode == 0, done.stderr
        return done

    walked = ("-c", WALK, "mujoco", "kinetic-energy", "compass")
    assert "compiled _torque" in run(*walked, folder="empty").stdout  # the test can fail
    printed = run("-m", "mjbiped", "compile", "kinetic-energy", "--engine", "mujoco").stdout
    assert printed.split() == ["compiled", "for", "the", "mujoco", "engine:", "kinetic-energy"]
    assert run(*walked).stdout == "walked\n"
    walk = ("walk", "random:seed=3", "--controller", "kinetic-energy", "--gain", "gain=21", "--steps", "2")
    assert "compiling" not in run("-m", "mjbiped", *walk).stderr


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_nor_does_one_with_knees(engine: str, tmp_path: Path) -> None:
    environment = {**os.environ, VARIABLE: "always", "NUMBA_CACHE_DIR": str(tmp_path)}
    made = [sys.executable, "-m", "mjbiped", "compile", "adaptive", "--engine", engine]
    subprocess.run(made, env=environment, check=True, capture_output=True, timeout=LONGEST)
    for name in ("adaptive", "passive"):  # the engine's code is there, and the passive controller has next to none
        walk = [sys.executable, "-c", WALK, engine, name, "kneed"]
        done = subprocess.run(walk, env=environment, check=True, capture_output=True, text=True, timeout=LONGEST)
        assert ("entry" in done.stdout, "walked" in done.stdout) == (False, True)
        assert name == "passive" or done.stdout == "walked\n"


TOES = "from controllers import PassivityController\n\n\nclass Toes(PassivityController):\n    joints = ('toe',)\n"


@pytest.mark.parametrize(
    ("controller", "engine", "words"),
    [
        ("adaptif", "hybrid", "adaptive"),
        ("adaptive", "mj", "hybrid"),
        ("toes.py:Toes", "hybrid", "drives toe: robots have ankle and hip and knee, or ankle and hip"),
    ],
)
def test_what_cannot_be_compiled_is_refused(
    controller: str, engine: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "toes.py").write_text(TOES)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=words):
        precompile([controller], engines=[engine])
