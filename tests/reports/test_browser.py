"""Reports in headless Chromium: they draw, they are linked, they play, and they ask the network for nothing.

`make test-browser` runs them.
"""

import shutil
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import mjbiped
from mjbiped.rendering.gl import gl_available
from mjbiped.reports.study import report_study
from mjbiped.reports.walk import report_walk
from mjbiped.studies.plan import plan
from mjbiped.studies.run import run

pytestmark = pytest.mark.browser

_FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update"]
_PATIENCE = 30.0  # s


class Opened:
    """A page in the browser, and what it said and asked for."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self.said: list[str] = []
        self.asked: list[str] = []
        page.on("console", lambda message: self.said.append(message.text))
        page.on("pageerror", lambda error: self.said.append(str(error)))
        page.on("request", lambda request: self.asked.append(request.url))

    def open(self, path: Path) -> None:
        self.said.clear()
        self.asked.clear()
        self.page.goto(path.as_uri())
        self.page.wait_for_selector("body[data-ready]", timeout=1e3 * _PATIENCE)

    def run(self, program: str) -> Any:
        return self.page.evaluate(program)

    def wait_until(self, condition: str) -> None:
        """Ask again and again: Playwright's own way needs eval, which the page's policy forbids."""
        until = time.monotonic() + _PATIENCE
        while not self.run(condition):
            assert time.monotonic() < until, f"never came: {condition}"
            self.page.wait_for_timeout(50)

    def assert_quiet(self, path: Path) -> None:
        assert self.said == []
        assert [url for url in self.asked if not url.startswith(("data:", "blob:"))] == [path.as_uri()]


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Opened]:
    from playwright.sync_api import sync_playwright

    chromium = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    assert chromium, "no Chromium: apt-get install chromium"
    with sync_playwright() as play:
        context = play.chromium.launch_persistent_context(
            tmp_path_factory.mktemp("profile"),
            executable_path=chromium,
            headless=True,
            args=_FLAGS,
            viewport={"width": 1280, "height": 900},
        )
        yield Opened(context.pages[0])
        context.close()


@pytest.fixture(scope="module")
def page(walk: mjbiped.Walk, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("walk") / "walk.html"
    report_walk(walk, path, video=gl_available() is not None)
    return path


def test_a_walk_is_drawn_without_a_word(browser: Opened, page: Path) -> None:
    browser.open(page)
    lines = "[...document.querySelectorAll('#plot-%s g.trace')].filter(t => t.querySelector('path.js-line')).length"
    assert browser.run(lines % "time") == 11
    assert browser.run(lines % "phases") >= 4  # a line and the gait for each leg, the transitions where there are any
    assert browser.run(lines % "ground") == 5
    browser.assert_quiet(page)


def test_all_figures_point_at_the_moment_that_one_points_at(browser: Opened, page: Path, walk: mjbiped.Walk) -> None:
    browser.open(page)
    plot = browser.page.locator("#plot-time")
    plot.scroll_into_view_if_needed()
    box = plot.bounding_box()
    browser.page.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + 400)
    browser.page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 400)
    browser.wait_until("Number(document.body.dataset.moment) > 1")
    browser.page.wait_for_timeout(500)  # ms: the last of the two moves is drawn
    moment = float(browser.run("document.body.dataset.moment"))
    # one label with the values of all six panels: eleven lines
    assert browser.run("document.querySelectorAll('#plot-time .hoverlayer .traces').length") == 11
    at = browser.run("document.getElementById('plot-time').layout.shapes[0].x0")
    assert at == pytest.approx(moment, abs=1e-3)  # ms, as it is written
    now = browser.run(
        "document.getElementById('plot-phases').data.filter(t => t.meta === 'now').map(t => [t.x[0], t.y[0]])"
    )
    k = int((walk.samples["time"] <= moment + 1e-3).sum()) - 1
    for leg in (0, 1):  # within the neighbouring sample: legs turn by less than 0.02 rad and 0.2 rad/s in 5 ms
        assert now[leg][0] == pytest.approx(walk.samples["q"][k, leg], abs=0.02)
    legs = browser.run("document.getElementById('plot-ground').data.filter(t => /now$/.test(t.name)).map(t => t.x[0])")
    assert legs == pytest.approx([walk.samples["qpos"][k, 0]] * 2, abs=0.01)  # m, the hip's way in 5 ms is 2.5 mm
    assert "step" in browser.page.inner_text("#now")
    assert browser.said == []


@pytest.mark.skipif(gl_available() is None, reason="no OpenGL platform")
def test_the_video_plays_and_the_cursor_follows(browser: Opened, page: Path, walk: mjbiped.Walk) -> None:
    browser.open(page)
    browser.wait_until("document.getElementById('video').readyState === 4")
    # the last frame is held for a second
    assert browser.run("document.getElementById('video').duration") == pytest.approx(walk.end[0] + 1.0, abs=0.1)
    browser.run("document.getElementById('video').currentTime = 2.0")
    browser.wait_until("document.body.dataset.moment === '2.000'")
    browser.run("document.getElementById('video').play()")
    browser.wait_until("Number(document.body.dataset.moment) > 2.3")
    browser.run("document.getElementById('video').pause()")
    assert browser.run("document.getElementById('video').error") is None
    browser.assert_quiet(page)


@pytest.mark.usefixtures("studies_in_threads")
@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("maps", {"controller": {"position_gain": [3, 5, 8]}, "terrain": {"name": "incline", "slope_deg": [1, 2, 3]}}),
        ("histograms", {"samples": 20, "terrain": {"name": "random", "seed": {"integer": [0, 99]}}}),
    ],
)
def test_studies(name: str, content: dict[str, object], browser: Opened, tmp_path: Path) -> None:
    """The page of a study is drawn without a word, and asks the network for nothing."""
    run(plan(tmp_path / "study.toml", {"engine": "hybrid", "steps": 3, **content}), tmp_path / name, workers=1)
    page = tmp_path / name / "report.html"
    report_study(tmp_path / name, page)
    browser.open(page)
    assert browser.run("document.querySelectorAll('.plot .subplot').length") >= 2
    browser.assert_quiet(page)
