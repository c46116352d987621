"""Packages of extras that are missing are named with a remedy; `controllers` has a second name that nothing hides."""

from pathlib import Path
from pkgutil import resolve_name

import pytest
from command_line import python, run_process

import controllers
import mjbiped
import mjbiped.controllers
from mjbiped.errors import InputError
from mjbiped.utils.packages import hidden_laws, needed


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
    done = python("program.py", cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, "Controller\n", "")
    walked = ("walk", "--steps", "1", "--engine", "hybrid", "--quiet")
    assert run_process(*walked, cwd=tmp_path).returncode == 0
    done = run_process(*walked, "--controller", "controllers.py:Spring", cwd=tmp_path)
    assert done.returncode == 2
    hidden = f"{tmp_path}/controllers.py hides mjbiped's package `controllers`"
    assert f"{hidden}: import from `mjbiped.controllers`" in done.stderr


def test_what_is_missing_is_named_with_its_extra() -> None:
    with pytest.raises(InputError, match=r"^a flight needs wings_of_wax, .*pip install 'mjbiped\[fly\]'$"):
        needed("wings_of_wax.left", "fly", "a flight")
