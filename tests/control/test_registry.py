"""Controllers by name: their settings with defaults and types, built anew from records, other packages' own."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
import own_controllers
import pytest

import mjbiped
from controllers import AdaptiveController
from mjbiped.control import registry
from mjbiped.control.loading import checked, value_of
from mjbiped.control.registry import controller_from, controller_names, make_controller, settings_of
from mjbiped.studies.run import law_folders


@pytest.mark.parametrize("name", controller_names())
def test_defaults_are_the_settings(name: str, robot: mjbiped.Compass, gait: mjbiped.Gait) -> None:
    """With them a controller is made, and with its description anew."""
    plain = make_controller(name, robot, {}, gait)
    assert make_controller(name, robot, settings_of(name), gait) == plain
    for key, model in (("gait", gait), ("robot", robot)):
        assert getattr(plain, key) is (model if key in plain.describe() else None)
    assert controller_from(plain.describe()) == plain


@pytest.mark.parametrize(
    ("name", "settings", "words"),
    [
        ("pid", {}, "unknown controller 'pid': valid are adaptive, .*energy-constraint, .*passive"),
        ("adaptive", {"robot": 1}, "position_gain=5.0, velocity_gain="),
        ("passivity", {"gian": 1}, "did you mean 'gain'"),
        ("adaptive", {"imitate_slope_deg": "steep"}, "imitate_slope_deg"),
        ("adaptive", {"position_gain": -1}, "position_gain"),
        ("adaptive", {"reference": "clearence=1"}, "reference 'clearence=1': .*did you mean 'clearance'"),
        ("adaptive", {"reference": "speed=1", "imitate_slope_deg": 1.0}, "give one of them"),
        ("kinetic-energy", {"reference": "clearance=0.1"}, "needs a passive gait"),
    ],
)
def test_refused_in_words(
    name: str, settings: dict[str, object], words: str, robot: mjbiped.Compass, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(registry, "reference_of", lambda *_, **__: pytest.fail("it searches"))
    with pytest.raises(mjbiped.InputError, match=words):
        make_controller(name, robot, settings)


def test_a_law_for_another_robot_is_told_with_those_that_fit(controller: AdaptiveController) -> None:
    with pytest.raises(mjbiped.InputError, match=r"choose a controller for that robot: adaptive \(KneedController\)"):
        mjbiped.walk(controller, mjbiped.Terrain.level(), robot=mjbiped.KneedBiped(), engine="hybrid")
    with pytest.raises(mjbiped.InputError, match="drives ankle, hip; KneedBiped has ankle, hip, knee"):
        make_controller("library", mjbiped.KneedBiped(), {})


def test_older_descriptions_have_defaults(robot: mjbiped.Compass, gait: mjbiped.Gait) -> None:
    """Those that do not fit are refused."""
    law = make_controller("adaptive", robot, {}, gait)
    described = law.describe()
    older = {name: value for name, value in described.items() if name != "replanning"}
    assert controller_from(older) == law
    without_gait = {name: value for name, value in older.items() if name != "gait"}
    for wrong, words in (
        ({**described, "name": "HipSpring"}, r"is a 'HipSpring', and only registered ones .* AdaptiveController"),
        ({**described, "momentum": 1.0}, r"AdaptiveController' cannot be built anew: .*momentum"),
        ({**described, "robot": {"mass": 5.0}}, r"cannot be built anew: .*mass"),
        (without_gait, r"needs a mjbiped\.Compass and a mjbiped\.Gait"),
    ):
        with pytest.raises(mjbiped.InputError, match=words):
            controller_from(wrong)


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The entry points of an installed distribution, to be written."""
    about = tmp_path / "own_laws-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: own-laws\nVersion: 1.0\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    registry.registered.cache_clear()
    yield about / "entry_points.txt"
    registry.registered.cache_clear()


def test_another_package_registers_its_own(robot: mjbiped.Compass, installed: Path) -> None:
    installed.write_text("[mjbiped.controllers]\nspread = own_laws:HipSpread\nlost = own_laws:Lost\n")
    source = own_controllers.write(installed.parents[1], "own_laws.py", own_controllers.SPREAD)
    assert controller_names()[0] == "adaptive"
    assert {"spread", "lost"} < {*controller_names()}
    assert source in law_folders()  # a study's results depend on it
    assert settings_of("spread") == {"stiffness": 0.5, "spread": 0.4}
    law = make_controller("spread", robot, {"stiffness": 5.0})
    assert law.describe() == {"name": "HipSpread", "stiffness": 5.0, "spread": 0.4}
    with pytest.raises(mjbiped.InputError, match="lost, registered as own_laws:Lost, fails"):
        make_controller("lost", robot, {})


def test_two_controllers_of_one_name_are_refused(installed: Path) -> None:
    installed.write_text("[mjbiped.controllers]\nadaptive = rival:Adaptive\n")
    with pytest.raises(mjbiped.InputError, match=r"two installed packages register .* adaptive: .*rival"):
        controller_names()


@dataclass
class Made:
    gain: float = 1.0
    count: int = 2
    on: bool = True
    mode: str = "soft"
    delay: float | None = 0.8
    kind: Literal["a", "b"] = "a"
    table: tuple[float, ...] = (1.0,)
    anything: Any = None


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("gain", " -2e-3 ", -2e-3),
        ("count", "3", 3),
        ("on", "True", True),
        ("mode", "5", "5"),
        ("delay", "none", None),
        ("kind", "b", "b"),
        ("anything", "7", 7),
        ("gain", "much", "gain = 'much': must be a finite number, as declared in Made"),
        *(("gain", text, "a finite number") for text in ("nan", "true", "none")),
        ("count", "2.5", "a whole number"),
        ("on", "1", "true or false"),
        ("delay", "soon", "a finite number or none"),
        ("kind", "c", "one of a, b"),
        ("table", "2, 1", (2, 1)),
        ("table", "1", "numbers with commas between them"),
    ],
)
def test_a_text_is_read_as_its_field_has_it_or_refused(name: str, text: str, value: object) -> None:
    if isinstance(value, str) and value != text.strip():
        with pytest.raises(mjbiped.InputError, match=value):
            value_of(Made, name, text)
    else:
        found = value_of(Made, name, text)
        assert (type(found), found) == (type(value), value)


def test_numbers_of_numpy_are_numbers_and_truth_is_none() -> None:
    assert checked(Made, "gain", np.float32(0.5)) == 0.5
    assert checked(Made, "count", np.int64(3)) == 3
    with pytest.raises(mjbiped.InputError, match="a whole number"):
        checked(Made, "count", True)
