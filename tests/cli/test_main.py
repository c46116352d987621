"""The whole command line: which commands there are, and what their help says."""

from __future__ import annotations

import re

import click
import pytest
from command_line import run

import mjbiped
from mjbiped.cli import main as cli

COMMANDS = (
    "walk",
    "compare",
    "gait",
    "reference",
    "return-map",
    "bifurcation",
    "basin",
    "stability",
    "figures",
    "render",
    "export",
    "view",
    "report",
    "sweep",
    "robustness",
    "reproduce",
    "compile",
)


def test_help_names_the_commands_in_order() -> None:
    result = run("--help")
    assert result.exit_code == 0
    listed = result.stdout[result.stdout.index("Commands:") :]
    assert re.findall(r"^  ([\w-]+)", listed, re.MULTILINE) == list(COMMANDS)


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_a_command_explains_every_option(command: str) -> None:
    text = run(command, "--help").stdout
    assert "Examples:" in text
    sentence = " ".join(str(cli.main.commands[command].help).partition("\n\n")[0].split())
    assert " ".join(run("--help").stdout.split()).count(f"{command} {sentence}") == 1  # said there without an import
    for parameter in cli.main.commands[command].params:
        if isinstance(parameter, click.Option):
            assert parameter.help, parameter.name
            assert parameter.opts[0] in text


def test_help_groups_options_and_shows_defaults() -> None:
    text = run("walk", "--help").stdout
    sections = re.findall(r"^(\w[\w ,-]*):$", text, re.MULTILINE)
    assert sections[-17:] == [
        "Walk",
        "Adaptive controller",
        "Comparison controllers",
        "Robot",
        "Disturbances",
        "MuJoCo",
        "Robot compass, footed, round",
        "Robot compass, footed, kneed, round, round-kneed, halved-rods",
        "Robot compass, footed, kneed, halved-rods",
        "Robot footed",
        "Robot kneed, round-kneed, halved-rods",
        "Robot wheel",
        "Robot round, round-kneed",
        "Robot round-kneed",
        "Results",
        "Video",
        "Options",
    ]
    assert text.count("[default:") > 15
    assert "[default: 0.8]" in text


def test_without_a_command_the_whole_help_is_shown() -> None:
    result = run()
    assert result.exit_code == 2
    assert result.stderr.strip() == run("--help").stdout.strip()


def test_a_law_without_gains_has_none_in_the_help() -> None:
    assert "policy: none;" in " ".join(run("walk", "--help").stdout.split())


def test_version() -> None:
    assert run("--version").stdout == f"mjbiped, version {mjbiped.__version__}\n"
