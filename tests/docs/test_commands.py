"""Every command on the pages exists, with its options, and takes the values that stand there."""

import importlib.util
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from documentation import PAGES, ROOT, blocks

from mjbiped.cli.main import main

READ = (".npz", ".csv", ".toml", ".yaml", ".py")  # files that a command may want to find


def commands() -> Iterator[tuple[str, list[str]]]:
    """Command lines of all pages, parted into words, each with its page."""
    for page in PAGES:
        for block in blocks(page):
            if block.language != "sh":
                continue
            for line in block.code.replace("\\\n", " ").splitlines():
                if words := shlex.split(line, comments=True):
                    yield page, words


def named(program: str) -> list[object]:
    return [
        pytest.param(words[1:], id=f"{page}: {' '.join(words)}"[:90])
        for page, words in commands()
        if Path(words[0]).name == program
    ]


@pytest.mark.parametrize("words", named("mjbiped"))
def test_mjbiped_takes_the_command(words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for word in words:
        name = word.partition(":")[0]
        if name.endswith(READ):
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).touch()
    context = main.make_context("mjbiped", [*words])
    command_name, command, rest = main.resolve_command(context, words)
    assert command is not None
    try:
        command.make_context(command_name, rest, parent=context)  # reads options and values, runs nothing
    except click.exceptions.Exit:
        assert set(words) & {"--help", "-h", "--version"}


@pytest.mark.parametrize("words", named("python"))
def test_scripts_exist(words: list[str]) -> None:
    if words[:1] == ["-m"] and words[1].startswith("scripts"):
        assert importlib.util.find_spec(words[1])


def test_make_has_the_targets() -> None:
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    assert {words[1] for _, words in commands() if words[0] == "make"} <= targets
