"""What imports load, which may not wait for what only some walks need; extras that are missing; both names of laws."""

from pathlib import Path
from pkgutil import resolve_name

import pytest
from command_line import python, run_process

import controllers
import mjbiped
import mjbiped.controllers
from mjbiped.errors import InputError
from mjbiped.utils.packages import hidden_laws, needed

# an import costs (CPU time, ms): numba 700, the parts of scipy 400, matplotlib 250, tqdm 50, yaml 15
LATER = (
    "numba llvmlite matplotlib PIL mediapy dm_control gymnasium tqdm yaml pandas pyarrow plotly jinja2 "
    "scipy.integrate scipy.linalg scipy.ndimage scipy.optimize"
)


ENGINES = f"{LATER} mujoco mjbiped.engines.mujoco.engine mjbiped.engines.hybrid.engine"
ALL = f"{LATER} mujoco numpy rich"


@pytest.mark.parametrize(
    ("module", "later"),
    [
        ("mjbiped", ALL),
        ("mjbiped.cli.main", ALL),  # `mjbiped --help`, and a command that does not exist
        ("mjbiped.cli.walks", ENGINES),  # `mjbiped walk --help`, and an option that does not exist
        ("controllers", ENGINES),
    ],
)
def test_an_import_loads_nothing_that_is_needed_later(module: str, later: str, tmp_path: Path) -> None:
    code = f"import sys, {module}; print(*[name for name in {later.split()} if name in sys.modules])"
    done = python("-c", code, cwd=tmp_path)
    assert (done.stdout.split(), done.stderr) == ([], "")


@pytest.mark.parametrize("name", mjbiped.__all__)
def test_every_public_name_is_where_the_stub_says(name: str) -> None:
    assert getattr(mjbiped, name) is not None


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
