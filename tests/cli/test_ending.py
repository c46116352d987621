"""A command that is interrupted, or whose controller fails, keeps what was walked."""

from __future__ import annotations

import json
import re
import signal
from pathlib import Path
from typing import Any

import pytest
from command_line import Drawings, python, run

from controllers import AdaptiveController
from mjbiped.records.columns import Recorder
from mjbiped.records.record import Walk


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_ctrl_c_and_sigterm_keep_the_walk_so_far(
    number: signal.Signals, status: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, drawings: Drawings
) -> None:
    add = Recorder.add
    count = iter(range(1000))

    def interrupted(*arguments: Any) -> None:
        add(*arguments)
        if next(count) == 3:
            signal.raise_signal(number)

    monkeypatch.setattr(Recorder, "add", interrupted)
    out, plot = tmp_path / "walk.npz", tmp_path / "walk.png"
    result = run("walk", "--timestep", 2e-4, "--out", out, "--plot", plot, "--json")
    assert result.exit_code == status
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL
    assert result.stderr == f"Error: the walk was interrupted after 0 steps; what was walked is in {out}\n"
    walk = Walk.load(out)
    assert walk.outcome == "interrupted"
    assert len(walk.samples["time"]) > 60  # of some 500 physics steps each time
    assert json.loads(result.stdout)["files"] == {"record": str(out)}
    assert not drawings.calls


def test_sigterm_ends_the_process_cleanly(tmp_path: Path) -> None:
    """In the midst of a file, with the exit status that shells have; a second one ends it at once."""
    program = tmp_path / "program.py"
    program.write_text(
        "import mjbiped, signal, sys, time\n"
        "from pathlib import Path\n"
        "from mjbiped.cli import main as cli\n"
        "from mjbiped.utils.files import written_whole\n"
        "def walk(*_, **__):\n"
        "    with written_whole(Path(sys.argv[1])) as unfinished:\n"
        "        unfinished.write_text('half')\n"
        "        signal.raise_signal(signal.SIGTERM)\n"
        "        time.sleep(600.0)\n"
        "mjbiped.walk = walk\n"
        "cli.main(['walk', 'level', '--controller', 'passive'])\n"
    )
    done = python(program, tmp_path / "walk.npz", cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (143, "", "Error: interrupted\n")
    assert [file.name for file in tmp_path.iterdir()] == [program.name]


def test_a_controller_that_fails_keeps_the_walk_so_far(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def on_touchdown(*_: object) -> None:
        raise ZeroDivisionError("no way on")

    monkeypatch.setattr(AdaptiveController, "on_touchdown", on_touchdown)
    monkeypatch.setattr(AdaptiveController, "law", lambda _: None)  # which would be compiled in its place
    out = tmp_path / "walk.npz"
    result = run("walk", "level", "--out", out, "--timestep", 5e-4)
    assert result.exit_code == 1
    assert re.fullmatch(
        rf"Error: AdaptiveController failed .*no way on .*{Path(__file__).name}.*; .* {re.escape(str(out))}\n",
        result.stderr,
    )
    assert "interrupted" in result.stdout
    assert Walk.load(out).outcome == "interrupted"
