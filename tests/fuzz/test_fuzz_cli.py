"""Command lines that nobody would write: each does what it says or is refused in words, and soon.

The lines are seeded: one that fails is the same again. Everything is read and checked, and whatever would be computed
is not; `make test-slow` tries more.
"""

import random
from collections.abc import Sequence
from pathlib import Path

import click
import pytest
from click.testing import CliRunner
from time_limits import within

from mjbiped.cli import main as cli

LONGEST = 2000  # characters on stderr
ABSURD = (
    "", " ", "0", "-1", "1", "2", "0.5", "-0.0", "nan", "inf", "-inf", "1e308", "-1e308", "1e-320", "1e400", "9" * 80,
    "-" + "9" * 80, "0." + "3" * 80, "9" * 5000, "x" * 5000, "1_000", "0x10", "1,5", "٣", "½", "１２", "1..2", "2..1",
    "1..1e400", "..", "0,0,0,0", "1,2,3,1e308", "none", "None", "true", "gait", "a=b", "=", "gain=1e308",
    "gain=9" + "9" * 80, "ratio=0", "-", "--", "--help", "é\u2028\x07", "\udcff", "%s{0}$(id)`id`", "*", "~", ".",
    "/", "/dev/null", "/dev/zero", "a/b/c", "folder", "folder.npz", "folder.toml", "folder.csv", "broken.npz",
    "broken.toml", "broken.csv", "missing.npz", "missing.toml", "missing.csv", "out.npz", "out.png", "out.mp4",
    "n" * 300 + ".npz", "folder/" * 1000 + "out.npz",
)  # fmt: skip
GROUNDS = (
    "level", "mixed", "incline:slope_deg=2", "incline:slope_deg=", "stairs:rise=-0.02,count=3", "stairs:tread=1e-320",
    "stairs:rise=1..2", "stairs:count=" + "9" * 80, "stairs:count=2,count=3", "slopes:change_deg=1e308",
    "slopes:count=99999", "random:seed=" + "9" * 80, "random:length=1e5,segment_length=1e-6..1e-6",
    "random:slope_deg=-1e308..1e308", "random:roughness=0.5", "moon:" + "x" * 5000, "level:", ":",
)  # fmt: skip
COMMANDS = "walk", "compare", "gait", "bifurcation", "basin", "stability", "render", "sweep", "reproduce"
TAKES_LONG = (
    *(f"limit_cycles.{name}.walk_all" for name in ("periodic", "return_map", "bifurcation", "basin")),
    *("studies.run.run", "studies.reproduction.reproduce.reproduce", "rendering.video.render_video"),
    *("plotting.walk.plot_walk", "plotting.gait.plot_gait", "Mujoco.start", "Hybrid.start"),
)


class Reached(BaseException):
    """A command has read and checked everything, and would begin to compute; no `except Exception` is to hold it up."""


@pytest.fixture
def nothing_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever takes long ends the command with `Reached`."""

    def reached(*_: object, **__: object) -> None:
        raise Reached

    for name in TAKES_LONG:
        monkeypatch.setattr(f"mjbiped.{name}", reached)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with folders and broken files."""
    for name in ("folder", "folder.npz", "folder.toml", "folder.csv"):
        (tmp_path / name).mkdir()
    (tmp_path / "broken.npz").write_bytes(b"PK\x03\x04 no zip")
    (tmp_path / "broken.toml").write_text("steps = [")
    (tmp_path / "broken.csv").write_text("0,0\n1,\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def line(chance: random.Random) -> list[str]:
    """A command line: a command, and up to four options."""
    if chance.random() < 0.03:
        return [chance.choice(ABSURD) for _ in range(chance.randrange(4))]
    name = chance.choice(COMMANDS)
    words = [name]
    parameters = cli.main.commands[name].params
    words += [
        chance.choice((*GROUNDS, *ABSURD) if parameter.name == "terrain" else ABSURD)
        for parameter in parameters
        if isinstance(parameter, click.Argument) and (parameter.required or chance.random() < 0.5)
    ]
    options = [parameter for parameter in parameters if isinstance(parameter, click.Option)]
    for option in chance.choices(options, k=chance.randrange(5)):
        words.append(chance.choice((*option.opts, *option.secondary_opts)))
        if not option.is_flag:
            valid = option.type.choices if isinstance(option.type, click.Choice) else ()
            words.append(str(chance.choice((*ABSURD, *valid, *(() if option.default is None else (option.default,))))))
    return words


def check(words: Sequence[str]) -> bool:
    """Run a command line; whether it was accepted."""
    shortened = [word[:100] for word in words]
    try:
        with within(20.0, shortened):
            result = CliRunner().invoke(cli.main, words)
    except Reached:
        return True
    assert result.exception is None or isinstance(result.exception, SystemExit), (shortened, result.exc_info)
    assert result.exit_code in (0, 2), (shortened, result.output)
    assert "Traceback" not in result.output, shortened
    if not words:  # the whole help
        return False
    assert len(result.stderr) < LONGEST, shortened
    assert result.exit_code == 0 or "Error: " in result.stderr, shortened
    return result.exit_code == 0


@pytest.mark.usefixtures("folder", "nothing_computed")
@pytest.mark.parametrize("count", [150, pytest.param(5000, marks=pytest.mark.slow)])
def test_command_lines_are_read_or_refused(count: int) -> None:
    chance = random.Random(count)
    accepted = sum(check(line(chance)) for _ in range(count))
    assert 0.05 * count < accepted < 0.7 * count  # neither all nonsense nor all sense
