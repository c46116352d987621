"""The gallery's programs draw what docs/gallery.md shows; the notebooks are executed, small, and their cells run."""

import json
import re
import runpy
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from PIL import Image

from mjbiped.robots.robot import Array

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted(path.stem for path in (ROOT / "examples").glob("*.py"))
PAGE = (ROOT / "docs" / "gallery.md").read_text()
FOLDER = ROOT / "docs" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
EACH = [name if name == "first_walk" else pytest.param(name, marks=pytest.mark.slow) for name in EXAMPLES]


@pytest.mark.parametrize("name", EACH)
def test_example_draws_its_pictures(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(ROOT / "examples" / f"{name}.py"), run_name="__main__")
    section = PAGE[: PAGE.index(f"../examples/{name}.py")].rsplit("## ", 1)[1]
    shown = set(re.findall(r"\(images/gallery/(\w+\.png)\)", section))
    assert {path.name for path in tmp_path.glob("*.png")} == shown
    for picture in shown:
        now, then = (small(folder / picture) for folder in (tmp_path, ROOT / "docs/images/gallery"))
        # two sizes of one picture, made small, are 0.004 apart
        assert np.abs(now - then).mean() < 0.01, picture


def small(picture: Path) -> Array:
    """A picture of 320 pixels across, from 0 to 1."""
    with Image.open(picture) as whole:
        return (
            np.asarray(whole.convert("RGB").resize((320, round(320 * whole.height / whole.width))), dtype=float) / 255
        )


def cells(path: Path) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return found


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_kept_executed_and_small(path: Path) -> None:
    code = [cell for cell in cells(path) if cell["cell_type"] == "code"]
    # from top to bottom in one go: `make notebooks`
    assert [cell["execution_count"] for cell in code] == list(range(1, len(code) + 1))
    kinds = {output["output_type"] for cell in code for output in cell["outputs"]}
    assert kinds <= {"execute_result", "stream"}  # no errors, nothing that only some front end shows
    assert path.stat().st_size < 300_000
    text = "".join("".join(cell["source"]) for cell in cells(path) if cell["cell_type"] == "markdown")
    assert all((FOLDER / link).exists() for link in re.findall(r"\]\(([^)#]+)", text))


@pytest.mark.parametrize(
    "path",
    [pytest.param(path, marks=() if path.stem == "first_walk" else pytest.mark.slow) for path in NOTEBOOKS],
    ids=lambda path: path.stem,
)
def test_its_cells_run(path: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    module = ModuleType("executed_notebook")
    monkeypatch.setitem(sys.modules, module.__name__, module)
    for cell in cells(path):
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), path.name, "exec", dont_inherit=True), module.__dict__)
    assert not list(tmp_path.iterdir())  # and leave nothing behind
