"""Packages of extras that are missing are named with a remedy; `controllers` has a second name that nothing hides."""

import os
import subprocess
import sys
from pathlib import Path
from pkgutil import resolve_name

import pytest

import controllers
import mjbiped
import mjbiped.controllers
from mjbiped.errors import InputError
from mjbiped.utils.packages import hidden_laws, needed

ROOT = str(Path(mjbiped.__file__).parents[1])


def run(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Python in a folder, with this checkout behind it."""
    environment = {**os.environ, "PYTHONPATH": ROOT}
    return subprocess.run([sys.executable, *words], cwd=folder, env=environment, capture_output=True, text=True)


def test_every_law_is_loaded_once_and_has_both_names() -> None:
    from controllers import adaptive as short
    from mjbiped.controllers import adaptive as whole

    assert controllers is mjbiped.controllers
    assert hidden_laws() == ""
    assert short is whole
    assert resolve_name("controllers.bounded.supervisor:SupervisedController") is controllers.SupervisedController


@pytest.mark.slow
def test_a_file_of_that_name_in_the_working_directory_hides_only_the_short_one(tmp_path: Path) -> None:
    (tmp_path / "controllers.py").write_text("from controllers import Controller\n")
    (tmp_path / "program.py").write_text("from mjbiped.controllers import Controller\nprint(Controller.__name__)\n")
    done = run(tmp_path, "program.py")
    assert (done.returncode, done.stdout, done.stderr) == (0, "Controller\n", "")
    walked = ("walk", "--steps", "1", "--engine", "hybrid", "--quiet")
    assert run(tmp_path, "-m", "mjbiped", *walked).returncode == 0
    done = run(tmp_path, "-m", "mjbiped", *walked, "--controller", "controllers.py:Spring")
    assert done.returncode == 2
    assert (
        f"{tmp_path}/controllers.py hides mjbiped's package `controllers`: import from `mjbiped.controllers`"
        in done.stderr
    )


def test_what_is_missing_is_named_with_its_extra() -> None:
    with pytest.raises(InputError, match=r"^a flight needs wings_of_wax, .*pip install 'mjbiped\[fly\]'$"):
        needed("wings_of_wax.left", "fly", "a flight")
