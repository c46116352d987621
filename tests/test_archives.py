"""What a release consists of: the archive of sources, and the wheel that others build from it."""

import json
import subprocess
import sys
import tarfile
import venv
from pathlib import Path

import pytest

HERE = Path(__file__).parents[1]


def run(*command: str | Path, folder: Path) -> str:
    done = subprocess.run([*map(str, command)], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
def test_a_wheel_made_from_the_source_archive_walks_in_an_empty_environment(tmp_path: Path) -> None:
    """The archive left the laws out, which a checkout has behind a link, and no walk could begin."""
    run(
        sys.executable, "-m", "build", "--outdir", tmp_path, HERE, folder=tmp_path
    )  # the wheel is made from the archive
    (archive,), (wheel,) = tmp_path.glob("*.tar.gz"), tmp_path.glob("*.whl")
    with tarfile.open(archive) as files:
        names = {name.partition("/")[2] for name in files.getnames()}
    assert {"Makefile", "controllers/adaptive.py", "mjbiped/controllers/adaptive.py", "tests/conftest.py"} <= names
    venv.create(tmp_path / "empty", with_pip=True)
    python = tmp_path / "empty" / "bin" / "python"
    run(python, "-m", "pip", "install", "--quiet", "-c", HERE / "constraints.txt", wheel, folder=tmp_path)
    told = run(python, "-m", "mjbiped", "walk", "level", "--steps", "3", "--json", folder=tmp_path)
    assert json.loads(told)["outcome"] == "finished"
    run(python, "-c", "from controllers import AdaptiveController", folder=tmp_path)
