"""What an import brings, and what is said where a package is missing."""

import subprocess
import sys

import pytest

WITHOUT = """
import sys
sys.modules[{missing!r}] = None
import mjbiped
try:
    {code}
except mjbiped.MjbipedError as error:
    print(error)
"""


@pytest.mark.parametrize(
    ("missing", "code", "said"),
    [
        ("gymnasium", "from mjbiped.envs import single", "pip install 'mjbiped[gym]'"),
        pytest.param("gymnasium", "print(sorted(mjbiped.envs.TASKS))", "walk_level", marks=pytest.mark.slow),
        pytest.param("dm_control", "mjbiped.envs.load('walk_level')", "pip install dm-control", marks=pytest.mark.slow),
        pytest.param(
            "labmaze", "print(mjbiped.envs.load('walk_level').reset().first())", "True", marks=pytest.mark.slow
        ),
    ],
)
def test_where_a_package_is_missing(missing: str, code: str, said: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT.format(missing=missing, code=code)], capture_output=True, text=True, check=True
    )
    assert said in done.stdout


def test_an_import_of_the_package_brings_neither_library() -> None:
    code = "import sys, mjbiped; print('gymnasium' in sys.modules or 'dm_control' in sys.modules); mjbiped.envs.TASKS"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False"]
