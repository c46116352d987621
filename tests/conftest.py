"""What many tests share: Table I's robot, its passive gait on 2 degrees, the paper's controller, and two walks."""

import math
import os
import signal
from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read at NumPy's import; more threads wait busily for each other

import hypothesis
import pytest
import stored_references

import mjbiped
from controllers import AdaptiveController, KneedController
from mjbiped.engines.base import Run
from mjbiped.engines.compiling import VARIABLE

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # a shell starts what runs in the background so, and processes that tests start and then interrupt would inherit it
    signal.signal(signal.SIGINT, signal.default_int_handler)

# how long an example takes is the machine's, and the first one compiles; each run draws others
hypothesis.settings.register_profile("mjbiped", deadline=None, max_examples=50)
hypothesis.settings.load_profile("mjbiped")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the tests that make machine code: the others walk by it, and interpret what it is not there for."""
    items.sort(key=lambda item: item.get_closest_marker("compiled") is None)


@pytest.fixture(autouse=True)
def compiles_where_marked(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tests marked `compiled` compile everything; the others do as a user's walks do."""
    if request.node.get_closest_marker("compiled"):
        monkeypatch.setenv(VARIABLE, "always")


@pytest.fixture(scope="session", autouse=True)
def references_of_their_own(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Gaits are stored for the tests or searched for, and are not taken from the user's cache nor left there."""
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent  # which the workers of a run share: one of them searches
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv("MJBIPED_CACHE_DIR", str(folder / "references"))
        stored_references.put_away()
        yield


@pytest.fixture(scope="session")
def robot() -> mjbiped.Compass:
    return mjbiped.Compass()


@pytest.fixture(scope="session")
def gait(robot: mjbiped.Compass) -> mjbiped.PassiveGait:
    return mjbiped.find_passive_gait(robot, math.radians(2))


@pytest.fixture(scope="session")
def controller(robot: mjbiped.Compass, gait: mjbiped.Gait) -> AdaptiveController:
    return AdaptiveController(robot, gait)


@pytest.fixture(scope="session")
def walk(controller: AdaptiveController) -> mjbiped.Walk:
    """Six steps on mixed ground."""
    return mjbiped.walk(controller, mjbiped.Terrain.mixed(), engine="hybrid", steps=6)


@pytest.fixture(scope="session")
def kneed() -> mjbiped.Walk:
    """Three steps with knees, uphill and steeply downhill."""
    robot = mjbiped.KneedBiped()
    law = KneedController(robot, mjbiped.find_kneed_gait(robot, math.radians(2.5)))
    ground = mjbiped.Terrain.from_segments([(0.7, -2.0), (9.0, 5.0)])
    return mjbiped.walk(law, ground, engine="hybrid", steps=3)


@pytest.fixture
def nothing_walks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Run, "go", lambda *_, **__: pytest.fail("it walks"))


@pytest.fixture
def studies_in_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """Studies walk in threads of this process: without the cost of starting others, and in reach of monkeypatches."""
    from mjbiped.studies import run

    @contextmanager
    def threads(count: int) -> Iterator[Executor]:
        with ThreadPoolExecutor(count) as pool:
            yield pool

    monkeypatch.setattr(run, "processes", threads)
