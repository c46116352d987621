"""Tables in Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def markdown_table(headings: Sequence[str], rows: Iterable[Sequence[str]], words: int | None = None) -> str:
    """Write a table in Markdown, without a line break at its end.

    Args:
        headings: Heading of each column.
        rows: Cells of each row.
        words: Number of columns, the first ones, that are aligned left; all others are aligned right. None aligns all
            columns left.
    """
    left = len(headings) if words is None else words
    rules = ["---"] * left + ["---:"] * (len(headings) - left)
    return "\n".join(f"| {' | '.join(cells)} |" for cells in (headings, rules, *rows))
