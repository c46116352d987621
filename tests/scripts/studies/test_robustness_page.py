"""The page on robustness takes its tables and figures from the folders of finished studies."""

from pathlib import Path

from click.testing import CliRunner

from mjbiped.studies.robustness_report import TABLES
from scripts.studies.robustness_page import FIGURES, main

LEVEL = "**Level ground, hybrid engine**\n\n| a |\n| --- |\n| 1 |\n\nof 3\n"
MARGINS = "**Margins on waves, hybrid engine**\n\n| b |\n| --- |\n| 2 |\n\nof 4\n"
STUDY = f"{LEVEL}\n{MARGINS}"
PAGE = "".join(f"<!-- {name} -->\nold\n<!-- end {name} -->\n" for name in ("hybrid", "mujoco", "margins"))


def test_places_are_filled_with_what_the_studies_wrote(tmp_path: Path) -> None:
    folder, images, page = tmp_path / "study", tmp_path / "images", tmp_path / "page.md"
    folder.mkdir()
    images.mkdir()
    (folder / TABLES).write_text(STUDY)
    for name in FIGURES:
        (folder / name).write_bytes(name.encode())
    page.write_text(PAGE)
    options = ["--page", str(page), "--images", str(images), "--hybrid", str(folder), "--margins", str(folder)]
    ended = CliRunner().invoke(main, options, catch_exceptions=False)
    assert ended.exit_code == 0
    level = "[Level ground, hybrid engine](tables/page/hybrid_level_ground_hybrid_engine.csv)\n\nof 3\n"
    margins = "[Margins on waves, hybrid engine](tables/page/{}_margins_on_waves_hybrid_engine.csv)\n\nof 4\n"
    assert page.read_text() == (
        f"<!-- hybrid -->\n{level}\n{margins.format('hybrid')}<!-- end hybrid -->\n"
        f"<!-- mujoco -->\nold\n<!-- end mujoco -->\n"
        f"<!-- margins -->\n{margins.format('margins')}<!-- end margins -->\n"
    )
    assert (tmp_path / "tables" / "page" / "margins_margins_on_waves_hybrid_engine.csv").read_text() == "b\n2\n"
    assert all((images / name).read_bytes() == name.encode() for name in FIGURES)
