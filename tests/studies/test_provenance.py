"""Stale results are not taken for fresh: every file that a number can depend on is in the digest of the sources."""

from pathlib import Path

import pytest

import controllers
import mjbiped
from mjbiped.engines.mujoco import scene
from mjbiped.studies.run import digest, machinery

COUNTED = (
    "mjbiped/engines/a.py",
    "mjbiped/studies/reproduction/cell.py",
    "mjbiped/studies/cell.py",
    "laws/sub/a.py",
    "models/a.xml",
)
LEFT_OUT = "mjbiped/cli/a.py", "mjbiped/plotting/a.py", "mjbiped/studies/reproduction/tables.py", "mjbiped/a.txt"


@pytest.fixture
def folders(tmp_path: Path) -> tuple[Path, list[Path], Path]:
    for place in (*COUNTED, *LEFT_OUT, "own_laws.py"):
        (tmp_path / place).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / place).write_text("1\n")
    return tmp_path / "mjbiped", [tmp_path / "laws", tmp_path / "own_laws.py"], tmp_path / "models"


def test_sources_are_those_that_are_imported() -> None:
    package, laws = Path(mjbiped.__file__).parent, Path(controllers.__file__).parent
    assert machinery()["sources"] == digest(package, [laws], scene.models_folder())


@pytest.mark.parametrize("place", [*COUNTED, "own_laws.py"])
def test_a_file_that_changes_or_moves_is_seen(place: str, folders: tuple[Path, list[Path], Path]) -> None:
    first, file = digest(*folders), folders[2].parent / place
    file.write_text("2\n")
    second = digest(*folders)
    if place in COUNTED:
        file.rename(file.with_stem("moved"))
    assert len({first, second, digest(*folders)}) == (3 if place in COUNTED else 2)


@pytest.mark.parametrize("place", LEFT_OUT)
def test_what_changes_no_number_is_left_out(place: str, folders: tuple[Path, list[Path], Path]) -> None:
    before = digest(*folders)
    (folders[2].parent / place).write_text("2\n")
    assert digest(*folders) == before
