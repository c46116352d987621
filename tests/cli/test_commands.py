"""Commands made of functions: their options stand in sections of the help, and reach the function if they are given."""

from dataclasses import dataclass
from typing import Annotated

import pytest
from click.testing import CliRunner

from mjbiped.cli.commands import Command, Given, options_of
from mjbiped.utils import domains


@dataclass
class Picture:
    """How a picture is to look.

    Picture:
        sharp: Draw fine lines,
            which take longer. None are left out.
        frames: How many there are each second.
    """

    sharp: bool = True
    frames: Annotated[int, domains.FPS, "fps"] = 30


@dataclass
class Walker:
    """What walks.

    Attributes:
        speed: How fast. Nobody asks for the rest.
    """

    speed: Annotated[float, domains.SPEED] = 0.5


def show(
    ground: str = "level",
    /,
    *,
    reach: Annotated[float | None, domains.REACH] = 0.5,
    picture: Picture,
    given: Annotated[Given, options_of(Walker, "Robot")],
) -> None:
    """Show what was given.

    Walk:
        reach: Leg lengths.
    """
    print(ground, reach, picture.sharp, picture.frames, given)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "level 0.5 True 30 {}\n"),
        (("stairs", "--reach", "none", "--no-sharp"), "stairs None False 30 {}\n"),
        (("--fps", "5", "--speed", "0.5"), "level 0.5 True 5 {'speed': 0.5}\n"),
    ],
)
def test_a_function_receives_what_was_given(words: tuple[str, ...], said: str) -> None:
    assert CliRunner().invoke(Command("show", show), words).output == said


def test_docstrings_are_the_help() -> None:
    text = CliRunner().invoke(Command("show", show), ["--help"]).output
    sections = [line for line in text.splitlines() if line.endswith(":")]
    assert sections == ["Walk:", "Picture:", "Robot:", "Options:"]
    words = " ".join(text.split())
    assert "--reach X|none Leg lengths. [default: 0.5]" in words
    assert "--sharp / --no-sharp Draw fine lines, which take longer. None are left out. [default: sharp]" in words
    assert "--speed X How fast. [default: 0.5]" in words
