"""What Sphinx does not look at: links between pages on GitHub, names in the glossary, tables that the site makes."""

import importlib
import re
from pydoc import locate

import pytest
from documentation import PAGES, ROOT, TABLES, table, text

from mjbiped.records import columns
from scripts.benchmarks import __main__ as benchmarks

LINK = re.compile(r"\]\((?!https?:)([^)#\s]*)(?:#([^)\s]+))?\)")
FENCED = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)


def anchors(page: str) -> set[str]:
    """What GitHub makes of the headings: small letters, hyphens for blanks, no marks."""
    headings = re.findall(r"^#+ (.*)$", FENCED.sub("", text(page)), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page: str) -> None:
    for name, anchor in LINK.findall(FENCED.sub("", text(page))):
        target = ((ROOT / page).parent / name).resolve() if name else ROOT / page
        assert target.exists(), name
        if anchor:
            assert anchor in anchors(str(target.relative_to(ROOT))), f"{name}#{anchor}"


def test_every_table_is_shown_by_a_page() -> None:
    """The site shows a table where its link is a paragraph by itself."""
    paragraphs = ((page, each) for page in PAGES for each in text(page).split("\n\n"))
    links = ((page, re.fullmatch(r"\s*\[[^]]+\]\(([\w/.]+\.csv)\)\s*", each)) for page, each in paragraphs)
    assert {(ROOT / page).parent / link[1] for page, link in links if link} == set(TABLES.rglob("*.csv"))


def exists(name: str) -> bool:
    """Whether a dotted name is a module's or a class's, a dataclass's field included."""
    above, _, last = name.rpartition(".")
    return locate(name) is not None or last in getattr(locate(above), "__dataclass_fields__", {})


def test_names_of_the_glossary_exist() -> None:
    page = text("docs/glossary.md")
    names = set(re.findall(r"`(\w+\.[\w.]+)`", page))
    assert len(names) > 10
    for name in names:
        assert any(exists(above + name) for above in ("", "mjbiped.", "mjbiped.records.", "controllers.")), name
    for name in re.findall(r'touchdowns\["(\w+)"\]', page):
        assert name in columns.TOUCHDOWNS
    assert not exists("mjbiped.Compass.foot_mass")


def test_tables_have_every_column_and_range(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "docs"))  # which is no package
    lookups = importlib.import_module("lookups")
    for name in ("samples", "touchdowns"):
        heads, *rows = getattr(lookups, name)()
        assert {len(row) for row in rows} == {len(heads)}
        assert {f"`{column}`" for column in getattr(columns, name.upper())} <= {row[0] for row in rows}
    assert ["`timestep`", "from 1e-06 to 0.004 s"] in lookups.limits()


def test_each_benchmark_has_its_table() -> None:
    for name, benchmark in benchmarks.BENCHMARKS.items():
        assert [*table("performance", name)[0]] == [heading.replace("`", "") for heading in benchmark.headings]
