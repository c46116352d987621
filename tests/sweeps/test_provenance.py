"""Stale results are not taken for fresh: every file that a number can depend on is in the digest of the sources."""

import shutil
from pathlib import Path

import pytest

import controllers
import mjbiped
from mjbiped.engines.mujoco import scene
from mjbiped.sweeps import run as provenance
from mjbiped.sweeps.run import sources

FOLDERS = (Path(mjbiped.__file__).parent, Path(controllers.__file__).parent, scene.models_folder())


def digest(package: Path, laws: Path, models: Path) -> str:
    return provenance.digest(package, [laws], models)


@pytest.fixture
def folders(tmp_path: Path) -> tuple[Path, ...]:
    """Copies of what the digest is made of."""
    copies = tuple(tmp_path / name for name in ("mjbiped", "controllers", "models"))
    for folder, copy in zip(FOLDERS, copies, strict=True):
        shutil.copytree(folder, copy, ignore=shutil.ignore_patterns("__pycache__"))
    return copies


def test_sources_are_those_that_are_imported(folders: tuple[Path, ...]) -> None:
    assert sources() == digest(*FOLDERS)
    assert digest(*folders) == digest(*folders)


@pytest.mark.parametrize(
    "place",
    [
        "mjbiped/new.py",
        "mjbiped/engines/new.py",
        "mjbiped/engines/mujoco/compiled/new.py",
        "mjbiped/engines/third/new.py",
        "mjbiped/reproduction/cell.py",
        "mjbiped/sweeps/cell.py",
        "mjbiped/engines/hybrid/gait_step.py",
        "mjbiped/robots/compass.py",
        "controllers/new.py",
        "controllers/comparison/new.py",
        "models/compass.xml",
    ],
)
def test_a_file_that_is_added_or_changed_is_seen(place: str, folders: tuple[Path, ...]) -> None:
    before, file = digest(*folders), folders[0].parent / place
    file.parent.mkdir(exist_ok=True)
    with file.open("a") as stream:
        stream.write("\n")
    assert digest(*folders) != before


@pytest.mark.parametrize(
    "place", ["mjbiped/cli/new.py", "mjbiped/plotting/new.py", "mjbiped/reproduction/report/new.py"]
)
def test_what_changes_no_number_is_left_out(place: str, folders: tuple[Path, ...]) -> None:
    before = digest(*folders)
    (folders[0].parent / place).write_text("")
    assert digest(*folders) == before


def test_a_law_in_no_package_is_seen(folders: tuple[Path, ...], tmp_path: Path) -> None:
    package, laws, models = folders
    own = tmp_path / "own_laws.py"
    own.write_text("gain = 1.0\n")
    before = provenance.digest(package, [laws, own], models)
    own.write_text("gain = 2.0\n")
    assert provenance.digest(package, [laws, own], models) != before


def test_a_file_that_moves_is_seen(folders: tuple[Path, ...]) -> None:
    before, file = digest(*folders), folders[0] / "robots" / "compass.py"
    file.rename(folders[0] / "compass.py")
    assert digest(*folders) != before
