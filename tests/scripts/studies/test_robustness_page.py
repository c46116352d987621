"""The page on robustness takes its tables and figures from the folders of finished studies."""

from pathlib import Path

from click.testing import CliRunner

from mjbiped.studies.robustness.report import TABLES
from scripts.studies.robustness_page import FIGURES, main

LEVEL = "**Level ground, hybrid engine**\n\n| a |\n| --- |\n| 1 |\n\nof 3\n"
MARGINS = "**Margins on waves, hybrid engine**\n\n| b |\n| --- |\n| 2 |\n\nof 4\n"
STUDY = f"{LEVEL}\n{MARGINS}"


def test_tables_are_those_that_the_studies_wrote(tmp_path: Path) -> None:
    folder, images, page = tmp_path / "study", tmp_path / "images", tmp_path / "page.md"
    folder.mkdir()
    images.mkdir()
    (folder / TABLES).write_text(STUDY)
    for name in FIGURES:
        (folder / name).write_bytes(name.encode())
    page.touch()
    options = ["--page", str(page), "--images", str(images), "--hybrid", str(folder), "--margins", str(folder)]
    ended = CliRunner().invoke(main, options, catch_exceptions=False)
    assert ended.exit_code == 0
    assert {file.name: file.read_text() for file in (tmp_path / "tables" / "page").iterdir()} == {
        "hybrid_level_ground_hybrid_engine.csv": "a\n1\n",
        "hybrid_margins_on_waves_hybrid_engine.csv": "b\n2\n",
        "margins_margins_on_waves_hybrid_engine.csv": "b\n2\n",
    }
    assert all((images / name).read_bytes() == name.encode() for name in FIGURES)
