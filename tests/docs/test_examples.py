"""The programs behind the gallery's pictures: each runs and draws what docs/gallery.md shows."""

import re
import runpy
from pathlib import Path

import matplotlib.image
import pytest

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted(path.stem for path in (ROOT / "examples").glob("*.py"))
QUICK = ("first_walk", "own_controller", "own_terrain")
PAGE = (ROOT / "docs" / "gallery.md").read_text()


EACH = [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in EXAMPLES]


@pytest.mark.parametrize("name", EACH)
def test_example_draws_its_pictures(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(ROOT / "examples" / f"{name}.py"), run_name="__main__")
    section = PAGE[: PAGE.index(f"../examples/{name}.py")].rsplit("## ", 1)[1]
    shown = set(re.findall(r"\(images/gallery/(\w+\.png)\)", section))
    assert {path.name for path in tmp_path.glob("*.png")} == shown
    for picture in shown:
        now, then = (matplotlib.image.imread(folder / picture) for folder in (tmp_path, ROOT / "docs/images/gallery"))
        assert now.std() > 0.02, f"{picture} is blank"
        assert now.shape[0] / now.shape[1] == pytest.approx(then.shape[0] / then.shape[1], rel=0.01)
