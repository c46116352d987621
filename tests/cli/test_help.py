"""The whole command line: its commands, what their help says, and options with the names that Python has for them."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import click
import pytest
from command_line import run

import controllers
import mjbiped
from mjbiped.cli.main import main
from mjbiped.control.registry import controller_names, settings_of
from mjbiped.robots.kinds import KINDS
from mjbiped.studies import plan as sweeps
from mjbiped.studies import robustness
from mjbiped.studies.plan import SCUFFING
from mjbiped.terrain.presets import PRESETS
from mjbiped.viewing import KEYS

NAMES_OF_COMMANDS = [
    "walk", "compare", "render", "view", "gait", "reference", "stability", "return-map", "bifurcation", "basin",
    "export", "report", "figures", "sweep", "robustness", "reproduce", "compile",
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
    sections = re.findall(r"^(\w[\w ,-]*):$", text, re.MULTILINE)[-17:]
    shared = [section for section in sections if not section.startswith("Robot ")]
    assert shared == ["Walk", "Adaptive controller", "Comparison controllers", "Robot", "Disturbances", "MuJoCo",
                      "Results", "Video", "Options"]  # fmt: skip
    assert "[default: 0.8]" in text
    words = " ".join(text.split()).replace("- ", "-")  # names are split at their hyphens
    assert all(f"{name}: " in words for name in controller_names() if name != "passive")
    assert "supervised: those of adaptive, and sole_share=0.95, climbing_clearance=" in words
    assert "policy: none;" in words
    keys = run("view", "--help").stdout
    assert all(key.name in keys and key.does in keys for key in KEYS.values())


# ---- names -----------------------------------------------------------------------------------------------------------

PUBLIC: tuple[Callable[..., Any], ...] = (
    *(each for name in mjbiped.__all__ if callable(each := getattr(mjbiped, name))),
    *(each for name in controllers.__all__ if inspect.isclass(each := getattr(controllers, name))),
    *(getattr(mjbiped.Terrain, name) for name in PRESETS),
)

OF_COMMANDS = (
    "out plot plot_width panels plot_multipliers video video_size no_video report parquet trajectories",
    "json quiet dry_run fresh quick scheduler clear for",
)
OF_OBJECTS = "scuffing_reach disturb push flag model_error reference imitate_slope_deg points grid"
OTHERS = {*" ".join((*OF_COMMANDS, OF_OBJECTS)).split()}
"""Options that have no name of Python's: of commands alone, and what is an object, an array or a field there."""

OF_STUDIES = {*["samples", "plot", "model", "grounds", "seeds", "limits", "margins"]}
"""Keys at the top of study files that neither `walk` nor its engine takes."""


def taken(public: Callable[..., Any]) -> Iterator[str]:
    """Names of arguments; those of a dataclass are its fields."""
    try:
        yield from inspect.signature(public).parameters
    except ValueError:  # an exception's
        return


NAMES = {name for public in PUBLIC for name in taken(public)}


def test_settings_have_the_names_of_python() -> None:
    """With `_deg` where degrees are given; every exception is an option, and no name of Python."""
    options = {
        (option.opts[0].removeprefix("--").replace("-", "_"), option.name)
        for command in COMMANDS.values()
        for option in command.params
        if isinstance(option, click.Option)
    }
    for written, becomes in options:
        assert written in OTHERS or written.removesuffix("_deg") in NAMES, written
        assert written == becomes or written in OTHERS, written
    assert {written for written, _ in options} >= OTHERS
    assert not {name.removesuffix("_deg") for name in OTHERS} & NAMES
    for name in controller_names():
        assert {key.removesuffix("_deg") for key in settings_of(name) if key not in OTHERS} <= NAMES
    arguments = {name for public in (mjbiped.walk, mjbiped.Mujoco, mjbiped.Terrain.random) for name in taken(public)}
    assert {*sweeps.KEYS, *robustness.KEYS} - arguments == OF_STUDIES
    assert {*SCUFFING} <= {*taken(mjbiped.ScuffingRule)}
    assert {name for kind in KINDS.values() for name in kind.parameters()} <= NAMES
