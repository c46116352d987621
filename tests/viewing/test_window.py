"""The window itself, on a screen in memory (Xvfb); `make test-viewer` installs and runs that."""

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mjbiped.records.signals import SIGNALS
from mjbiped.utils import palette

TOOLS = ("Xvfb", "xdotool", "import")
missing = [name for name in TOOLS if shutil.which(name) is None]
needs_xvfb = pytest.mark.skipif(
    bool(missing) or not sys.platform.startswith("linux"),
    reason=f"no {', '.join(missing) or 'Linux'}: `make test-viewer` installs what is missing on Debian, and runs this",
)
pytestmark = [needs_xvfb, pytest.mark.viewer]


@pytest.fixture(scope="module")
def screen() -> Iterator[str]:
    read, write = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(write), "-screen", "0", "1440x900x24"], pass_fds=[write], stderr=subprocess.DEVNULL
    )
    os.close(write)
    with os.fdopen(read) as answer:
        display = f":{answer.readline().strip()}"
    yield display
    server.terminate()
    server.wait()


class Viewed:
    """`mjbiped view` in a process of its own, and what a user does with it."""

    def __init__(self, screen: str, *words: str) -> None:
        self.environment = {**os.environ, "DISPLAY": screen}
        command = [sys.executable, "-m", "mjbiped", "view", *words]
        self.process = subprocess.Popen(command, env=self.environment, stdout=subprocess.PIPE, text=True)
        self.window = ""
        limit = time.monotonic() + 90.0
        while not self.window:
            assert self.process.poll() is None
            assert time.monotonic() < limit
            found = self.tool("xdotool", "search", "--name", "MuJoCo")
            self.window = found.split()[0] if found else ""
            time.sleep(0.2)
        time.sleep(1.5)  # until it has drawn

    def tool(self, *command: str) -> str:
        return subprocess.run(command, env=self.environment, capture_output=True, text=True, timeout=30).stdout

    def press(self, *keys: str) -> None:
        self.tool("xdotool", "key", *keys)
        time.sleep(1.0)

    def shot(self, path: Path) -> np.ndarray:
        self.tool("import", "-window", self.window, str(path))
        return np.asarray(Image.open(path).convert("RGB"), dtype=int)

    def closed(self) -> str:
        """Its last words, after it has closed by itself."""
        output, _ = self.process.communicate(timeout=60)
        assert self.process.returncode == 0
        return output


def near(picture: np.ndarray, colour: tuple[int, int, int]) -> np.ndarray:
    """Columns and rows of the pixels of a colour, shape (n, 2)."""
    rows, columns = np.nonzero(np.abs(picture - colour).max(axis=2) < 30)
    return np.stack([columns, rows], axis=1)


def test_keys_and_a_push_with_the_mouse(screen: str, tmp_path: Path) -> None:
    viewed = Viewed(screen, "incline:slope_deg=2", "--for", "20", "--hide", "traces,shadows")
    viewed.press("F8", "space", "BackSpace")
    start, again = viewed.shot(tmp_path / "start.png"), viewed.shot(tmp_path / "again.png")
    assert np.array_equal(start, again)  # it is paused
    left_half = start[:, : start.shape[1] // 2]
    hip = near(left_half[: start.shape[0] // 2], (38, 38, 45))
    x, y = (round(float(each)) for each in np.median(hip, axis=0))
    viewed.tool("xdotool", "mousemove", str(x), str(y), "click", "--repeat", "2", "--delay", "60", "1")
    time.sleep(0.5)
    viewed.press("space")
    viewed.tool("xdotool", "keydown", "ctrl", "mousedown", "3")
    for way in (20, 80, 200):
        viewed.tool("xdotool", "mousemove", str(x + way), str(y))
        time.sleep(0.2)
    pushed = viewed.shot(tmp_path / "pushed.png")
    viewed.tool("xdotool", "mouseup", "3", "keyup", "ctrl")
    assert len(near(pushed, (255, 0, 0))) > 100  # MuJoCo's arrow from the hip to the mouse
    # the controller takes the pull for a steep slope, whose line goes far below the feet
    red, green, blue = (round(255 * share) for share in palette.rgb(SIGNALS["slope_estimate"].colour))
    lowest = [near(picture, (red, green, blue))[:, 1].max() for picture in (start, pushed)]
    assert lowest[1] > lowest[0] + 20
    assert "step" in viewed.closed()
