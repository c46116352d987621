"""The pages as tests read them: README.md, docs/, and the blocks of code in them."""

import csv
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from scripts.pages import file_of

ROOT = Path(__file__).parents[1]
TABLES = ROOT / "docs/tables"
PAGES = (
    "README.md",
    "CONTRIBUTING.md",
    "models/README.md",
    *(f"docs/{page.name}" for page in sorted((ROOT / "docs").glob("*.md"))),
    *(f"docs/tables/{page.name}" for page in sorted(TABLES.glob("*.md"))),
)

_BLOCK = re.compile(r"^```(\w+)([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


class Block(NamedTuple):
    """A fenced block of code.

    Attributes:
        language: The word behind the fence.
        marks: The words after it: `notest` (is not run), `slow` (is run by `make test-slow` alone), `file=NAME` (is a
            file beside the program).
        line: Of the page where the code begins, from 1.
        code: What stands in it.
    """

    language: str
    marks: frozenset[str]
    line: int
    code: str

    @property
    def file(self) -> str | None:
        """The name of the file that it is."""
        return next((mark.removeprefix("file=") for mark in self.marks if mark.startswith("file=")), None)


def text(page: str) -> str:
    """What stands on a page."""
    return (ROOT / page).read_text(encoding="utf-8")


def blocks(page: str) -> Iterator[Block]:
    """All fenced blocks of a page, in order."""
    written = text(page)
    for match in _BLOCK.finditer(written):
        language, marks, code = match.groups()
        yield Block(language, frozenset(marks.split()), written.count("\n", 0, match.start(3)) + 1, code)


def table(page: str, name: str) -> list[dict[str, str]]:
    """A table that a study wrote for a page, by the headings."""
    with file_of(TABLES / page, name).open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(lines))
