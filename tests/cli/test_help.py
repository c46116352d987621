"""The whole command line: its commands, and what their help says."""

import re
from collections.abc import Mapping

import click
import pytest
from command_line import run

import mjbiped
from mjbiped.cli.main import main
from mjbiped.control.registry import controller_names
from mjbiped.viewing import KEYS

NAMES_OF_COMMANDS = [
    "walk", "compare", "render", "view", "gait", "reference", "stability", "return-map", "bifurcation", "basin",
    "lateral-basin", "export", "report", "figures", "sweep", "robustness", "reproduce", "compile",
]  # fmt: skip
COMMANDS: Mapping[str, click.Command] = main.commands


def test_help_names_the_commands_in_order() -> None:
    whole = run("--help")
    listed = whole.stdout[whole.stdout.index("Commands:") :]
    assert re.findall(r"^  ([\w-]+)", listed, re.MULTILINE) == NAMES_OF_COMMANDS == [*COMMANDS]
    without = run()
    assert (without.exit_code, without.stderr.strip()) == (2, whole.stdout.strip())
    assert run("--version").stdout == f"mjbiped, version {mjbiped.__version__}\n"


@pytest.mark.parametrize("command", NAMES_OF_COMMANDS)
def test_help_of_a_command_explains_every_option(command: str) -> None:
    text = run(command, "--help").stdout
    assert "Examples:" in text
    assert ".md" not in text  # an installed package has no pages
    sentence = " ".join(str(COMMANDS[command].help).partition("\n\n")[0].split())
    assert " ".join(run("--help").stdout.split()).count(f"{command} {sentence}") == 1  # said there without an import
    for parameter in COMMANDS[command].params:
        if isinstance(parameter, click.Option):
            assert parameter.help, parameter.name
            assert parameter.opts[0] in text


def test_help_of_walks_tells_sections_defaults_gains_and_keys() -> None:
    text = run("walk", "--help").stdout
    assert "[default: 0.8]" in text
    words = " ".join(text.split()).replace("- ", "-")  # names are split at their hyphens
    assert all(f"{name}: " in words for name in controller_names() if name != "passive")
    assert "supervised: those of adaptive, and sole_share=0.95, climbing_clearance=" in words
    assert "policy: none;" in words
    keys = run("view", "--help").stdout
    assert all(key.name in keys and key.does in keys for key in KEYS.values())
