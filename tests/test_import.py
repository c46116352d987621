"""What `import mjbiped` and the command line load: neither may wait for what only some walks need."""

import subprocess
import sys

import pytest

# an import costs (CPU time, ms): numba 700, the parts of scipy 400, matplotlib 250, tqdm 50, yaml 15
LATER = (
    "numba llvmlite matplotlib PIL mediapy dm_control gymnasium tqdm yaml scipy.integrate scipy.linalg scipy.ndimage "
    "scipy.optimize "
    "pandas pyarrow plotly jinja2"
)


@pytest.mark.parametrize("module", ["mjbiped", "controllers", "mjbiped.cli.main"])
def test_an_import_loads_nothing_that_only_some_walks_need(module: str) -> None:
    code = f"import sys, {module}; print(*[name for name in {LATER.split()} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
    assert done.stderr == ""
