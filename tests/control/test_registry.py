"""Controllers by name: each has its settings with their defaults, and nothing else."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import pytest

import mjbiped
from controllers import AdaptiveController, LimitCycleController, PassiveController, PassivityController
from mjbiped.control import registry
from mjbiped.control.registry import (
    controller_from,
    controller_names,
    make_controller,
    parse_reference,
    registered,
    settings_of,
)
from mjbiped.controllers.comparison.known_slope import KnownSlopeController
from mjbiped.errors import InputError
from mjbiped.studies.run import law_folders


@pytest.mark.parametrize("name", controller_names())
def test_defaults_are_the_settings(name: str, robot: mjbiped.Compass, gait: mjbiped.Gait) -> None:
    plain = make_controller(name, robot, {}, gait)
    assert make_controller(name, robot, settings_of(name), gait).describe() == plain.describe()
    for key, model in (("gait", gait), ("robot", robot)):
        assert getattr(plain, key) is (model if key in plain.describe() else None)


def test_the_passive_controller_has_no_settings(robot: mjbiped.Compass) -> None:
    assert make_controller("passive", robot, {}) == PassiveController()


def test_settings_arrive(robot: mjbiped.Compass) -> None:
    law = make_controller("adaptive", robot, {"imitate_slope_deg": 1.0, "position_gain": 3, "replanning_delay": None})
    assert isinstance(law, AdaptiveController)
    assert (law.gait.slope, law.position_gain, law.replanning_delay) == (math.radians(1.0), 3, None)
    given = make_controller("passivity", robot, {"gain": 2.0, "initial_slope_estimate_deg": 3, "slope_source": "none"})
    assert isinstance(given, PassivityController)
    assert (given.gain, given.initial_slope_estimate, given.slope_source) == (2.0, math.radians(3.0), "none")


def test_slope_source_has_the_default_of_its_controller(robot: mjbiped.Compass, gait: mjbiped.Gait) -> None:
    assert settings_of("passivity")["slope_source"] == PassivityController(robot, gait).slope_source == "two_point"
    limit = LimitCycleController(robot, gait)
    assert isinstance(limit, KnownSlopeController)
    assert settings_of("limit-cycle")["slope_source"] == limit.slope_source


@pytest.mark.parametrize(
    ("name", "settings", "words"),
    [
        ("pid", {}, "unknown controller 'pid': valid are adaptive, .*energy-constraint, .*passive"),
        ("passive", {"gain": 1}, "valid are none"),
        ("adaptive", {"robot": 1}, "position_gain=5.0, velocity_gain="),
        ("passivity", {"gian": 1}, "did you mean 'gain'"),
        ("adaptive", {"imitate_slope_deg": "steep"}, "imitate_slope_deg"),
        ("kinetic-energy", {"initial_slope_estimate_deg": math.nan}, "initial_slope_estimate_deg"),
        ("adaptive", {"position_gain": -1}, "position_gain"),
    ],
)
def test_refused_in_words(name: str, settings: dict[str, object], words: str, robot: mjbiped.Compass) -> None:
    with pytest.raises(InputError, match=words):
        make_controller(name, robot, settings)


@pytest.mark.parametrize("name", controller_names())
def test_a_description_is_built_anew(name: str, robot: mjbiped.Compass, gait: mjbiped.Gait) -> None:
    law = make_controller(name, robot, {}, gait)
    assert controller_from(law.describe()) == law


def test_descriptions_that_do_not_fit_are_refused(robot: mjbiped.Compass, gait: mjbiped.Gait) -> None:
    described = make_controller("passivity", robot, {}, gait).describe()
    with pytest.raises(InputError, match=r"is a 'HipSpring', and only registered ones .* PassivityController"):
        controller_from({**described, "name": "HipSpring"})
    with pytest.raises(InputError, match=r"PassivityController' cannot be built anew: .*momentum"):
        controller_from({**described, "momentum": 1.0})
    with pytest.raises(InputError, match=r"cannot be built anew: .*mass"):
        controller_from({**described, "robot": {"mass": 5.0}})


def test_records_from_before_a_field_was_there_are_built_with_its_default(
    robot: mjbiped.Compass, gait: mjbiped.Gait
) -> None:
    law = make_controller("adaptive", robot, {}, gait)
    older = {name: value for name, value in law.describe().items() if name != "replanning"}
    assert controller_from(older) == law
    without_gait = {name: value for name, value in older.items() if name != "gait"}
    with pytest.raises(InputError, match=r"needs a mjbiped\.Compass and a mjbiped\.Gait"):
        controller_from(without_gait)


def test_two_controllers_of_one_name_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    about = tmp_path / "rival-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: rival\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("[mjbiped.controllers]\nadaptive = rival:Adaptive\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    registered.cache_clear()
    try:
        with pytest.raises(InputError, match=r"two installed packages register the controller adaptive: .*rival:Ad"):
            controller_names()
    finally:
        registered.cache_clear()


@pytest.fixture
def own_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """An installed distribution that registers two controllers, of which one does not exist."""
    (tmp_path / "own_laws.py").write_text(
        "from dataclasses import dataclass\n"
        "from controllers import Controller\n"
        "@dataclass(frozen=True)\n"
        "class HipSpread(Controller):\n"
        "    stiffness: float = 20.0\n"
        "    def torque(self, memory, t, q, dq):\n"
        "        return 0.0, -self.stiffness * (q[1] - q[0] - 0.4)\n"
    )
    about = tmp_path / "own_laws-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: own-laws\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(
        "[mjbiped.controllers]\nspread = own_laws:HipSpread\nlost = own_laws:Lost\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    registered.cache_clear()
    yield
    registered.cache_clear()


@pytest.mark.usefixtures("own_package")
def test_another_package_registers_its_own(robot: mjbiped.Compass, tmp_path: Path) -> None:
    assert controller_names()[0] == "adaptive"
    assert {"spread", "lost"} < {*controller_names()}
    assert settings_of("spread") == {"stiffness": 20.0}
    assert tmp_path / "own_laws.py" in law_folders()  # a study's results depend on it
    law = make_controller("spread", robot, {"stiffness": 5.0})
    assert law.describe() == {"name": "HipSpread", "stiffness": 5.0}
    with pytest.raises(InputError, match="lost, registered as own_laws:Lost, fails"):
        make_controller("lost", robot, {})


def test_a_law_that_imitates_passive_walking_is_refused_a_reference_before_any_search(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(registry, "find_reference", lambda *_, **__: pytest.fail("it searches"))
    with pytest.raises(InputError, match="needs a passive gait"):
        make_controller("kinetic-energy", mjbiped.Compass(), {"reference": "clearance=0.1"})


def test_references_in_words() -> None:
    assert parse_reference("clearance=0.06, speed = 0.5") == {"clearance": 0.06, "speed": 0.5}
    assert parse_reference("retraction=no") == {"retraction": False}
    for text, message in (
        ("clearance", "clearance = '': must be a finite number"),
        ("clearence=1", "reference 'clearence=1': .*did you mean 'clearance'"),
        ("speed=1,speed=2", "stands twice"),
        ("speed=fast", "must be a finite number"),
        ("speed=nan", "must be a finite number"),
        ("retraction=0", "must be true or false"),
    ):
        with pytest.raises(InputError, match=message):
            parse_reference(text)
