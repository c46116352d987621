"""Controllers of a user's own by the names of their classes: loaded in words or refused in words, and told of."""

import sys
from collections.abc import Iterator
from pathlib import Path

import own_controllers
import pytest

import mjbiped
from mjbiped.control.loading import digest_of, own_class, source_of
from mjbiped.control.registry import make_controller, settings_of


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The working directory, from which nothing stays in Python's path or among its modules."""
    monkeypatch.chdir(tmp_path)
    path, modules = [*sys.path], {*sys.modules}
    yield tmp_path
    sys.path[:] = path
    for name in {*sys.modules} - modules:
        if str(tmp_path) in str(getattr(sys.modules[name], "__file__", "")):
            del sys.modules[name]


def test_a_class_in_a_file_walks(folder: Path, robot: mjbiped.Compass, capsys: pytest.CaptureFixture[str]) -> None:
    """It can be called as you like and imports what is beside it; the record says whence it came."""
    text = "from helper_b import SPREAD\nprint('loaded')\n" + own_controllers.SPREAD
    own_controllers.write(folder, "helper_b.py", "import deeper_b\nSPREAD = deeper_b.SPREAD\n")
    own_controllers.write(folder, "deeper_b.py", "SPREAD = 0.4\n")
    for name in ("controllers.py", "other/spread.py", "other/helper_b.py"):
        own_controllers.write(folder, name, text if "helper" not in name else "")
    law = make_controller("controllers.py:HipSpread", robot, {"stiffness": 0.45})
    assert capsys.readouterr() == ("", "loaded\n")
    assert law.describe() == {"name": "HipSpread", "stiffness": 0.45, "spread": 0.4}
    walk = mjbiped.walk(law, mjbiped.Terrain.incline(2.0), engine="hybrid", steps=2)
    source = walk.settings["controller_source"]
    assert source == {"class": "controllers.py:HipSpread", "sha256": digest_of("other/spread.py:HipSpread")}


def test_a_class_in_a_package_of_the_working_directory(folder: Path) -> None:
    own_controllers.write(folder, "my_laws_a/hip/spread.py", own_controllers.SPREAD)
    own_controllers.write(folder, "my_laws_a/unused.py", "")
    kind = own_class("my_laws_a.hip.spread:HipSpread")
    assert kind.__module__ == "my_laws_a.hip.spread"
    before = digest_of("my_laws_a.hip.spread:HipSpread")
    own_controllers.write(folder, "my_laws_a/hip/spread.py", own_controllers.SPREAD + "# changed\n")
    assert digest_of("my_laws_a.hip.spread:HipSpread") != before


def test_an_edited_file_is_loaded_again(folder: Path) -> None:
    """Within the second, and of the same length: what Python keeps of compiled files would be taken for it."""
    own_controllers.write(folder, "spread.py", own_controllers.SPREAD)
    first = own_class("spread.py:HipSpread")
    assert own_class(f"{folder}/spread.py:HipSpread") is first, "one file, one class"
    own_controllers.write(folder, "spread.py", own_controllers.SPREAD.replace("0.5", "0.6"))
    assert settings_of("spread.py:HipSpread")["stiffness"] == 0.6
    assert source_of(own_class("spread.py:HipSpread")) != source_of(first)
    assert not (folder / "__pycache__").exists()


PLAIN = "return 0.0, 0.0"
DATACLASS = "from dataclasses import dataclass\n@dataclass(frozen=True)"
TEXTS = {  # of law.py, and what is said of its class Law
    "x = 1\ndef f(:\n": "law.py cannot be loaded: SyntaxError: .*law.py, line 2",
    "import math\nx = 1 / 0\n": r"ZeroDivisionError: division by zero \(law.py, line 2: x = 1 / 0\)",
    own_controllers.law(PLAIN).replace("Law", "Laws"): "valid are Laws; did you mean 'Laws'",
    "Law = 3\n": "Law in law.py does not derive from controllers.Controller",
    "from controllers import Controller\nclass Law(Controller):\n    pass\n": "lacks torque",
    own_controllers.law(PLAIN, above=DATACLASS, fields="k: float"): r"missing .*'k'; they are k \(needed\)",
    own_controllers.law(PLAIN, fields="def __init__(self, k):\n    self.k = k"): "none; Law is no dataclass",
    own_controllers.law(PLAIN, fields="def __init__(self):\n    raise KeyError('no')"): r"'no' \(law.py, line 6, in __",
}
REFERENCES = {
    "gone.py:Law": "'gone.py' .*there is no such file",
    "folder.py:Law": "is a folder",
    "./law:Law": "must end in .py",
    "not-a-name:Law": "is no name of a module",
    ":Law": "names no file or module",
    "law.py": "names no class; give it as law.py:Law",
}


@pytest.mark.parametrize(
    ("text", "reference", "words"),
    [
        *((text, "law.py:Law", words) for text, words in TEXTS.items()),
        *((own_controllers.law(PLAIN), reference, words) for reference, words in REFERENCES.items()),
    ],
)
def test_refused_in_words(text: str, reference: str, words: str, folder: Path, robot: mjbiped.Compass) -> None:
    own_controllers.write(folder, "law.py", text)
    (folder / "folder.py").mkdir()
    with pytest.raises(mjbiped.InputError, match=words):
        make_controller(reference, robot, {})


def test_an_interruption_is_nobodys_mistake(folder: Path) -> None:
    own_controllers.write(folder, "law.py", "raise KeyboardInterrupt\n")
    with pytest.raises(KeyboardInterrupt):
        own_class("law.py:Law")
