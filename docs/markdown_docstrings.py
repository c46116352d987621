"""Docstrings have tables, headings and blocks of code in Markdown, as Gymnasium's do; Sphinx reads reStructuredText."""

import re
from collections.abc import Iterator, Sequence
from itertools import groupby

TABLE = re.compile(r"^(\s*)\|(.*)\|\s*$")
CELLS = re.compile(r"(?<!\\)\|")
HEADING = re.compile(r"^(\s*)#{2,3} (.*)$")
FENCE = re.compile(r"^(\s*)```(\w*)\s*$")


def _list_table(lines: Sequence[str]) -> Iterator[str]:
    """A Markdown table, whose second line is the one of dashes, as a `list-table`."""
    rows = [match.groups() for match in map(TABLE.match, lines) if match]
    indent = rows[0][0]
    yield from ("", f"{indent}.. list-table::", f"{indent}   :header-rows: 1", "")
    for _, row in (rows[0], *rows[2:]):
        for number, cell in enumerate(CELLS.split(row)):
            yield f"{indent}   {' ' if number else '*'} - {cell.strip()}".rstrip()
    yield ""


def _text(lines: Sequence[str]) -> Iterator[str]:
    """Lines outside tables: headings become rubrics, fenced code becomes a `code-block`."""
    in_code = False
    for line in lines:
        fence, heading = FENCE.match(line), HEADING.match(line)
        if fence:
            in_code = not in_code
            yield from ("", f"{fence[1]}.. code-block:: {fence[2]}", "") if in_code else ("",)
        elif in_code:
            yield f"   {line}"
        elif heading:
            yield from ("", f"{heading[1]}.. rubric:: {heading[2]}", "")
        else:
            yield line


def as_restructured_text(lines: Sequence[str]) -> list[str]:
    """A docstring's lines in reStructuredText.

    Args:
        lines: Of the docstring, with Markdown tables, headings and fenced code at any indentation.
    """
    out: list[str] = []
    for is_table, part in groupby(lines, key=lambda line: bool(TABLE.match(line))):
        write = _list_table if is_table else _text
        out += write([*part])
    return out
