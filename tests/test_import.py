"""What `import mjbiped` and the command line load: neither may wait for what only some walks need."""

from pathlib import Path

import pytest
from command_line import python

import mjbiped

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
