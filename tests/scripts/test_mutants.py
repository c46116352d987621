"""Mutants: what is changed where, that a sample is the same again, and, slowly, that the tests notice them."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from scripts import mutants
from scripts.mutants import EQUIVALENT, ROOMS, ROOT

SOURCE = '''"""What it is: 1 + 1."""

FACTOR = 2.0


def faster(speed: float = 1.0, *rest: int) -> float:
    """Not 1 - 1."""
    if speed < 0.0 and rest:
        raise ValueError(f"{speed - 1}")
    total = -speed + FACTOR * max(rest[0], 3)  # + é
    total += 2.0
    return total if rest else 0.5
'''

CHANGED = {
    "if (speed >= 0.0) and rest:",
    "if (speed < 0.0 or rest):",
    "total = (-speed - FACTOR * max(rest[0], 3))  # + é",
    "total = (-speed)  # + é",
    "total = (speed) + FACTOR * max(rest[0], 3)  # + é",
    "total = -speed + (FACTOR / max(rest[0], 3))  # + é",
    "total = -speed + FACTOR * (min)(rest[0], 3)  # + é",
    "total = -speed + FACTOR * max(rest[(1)], 3)  # + é",
    "total = -speed + FACTOR * max(rest[0], (4))  # + é",
    "total -= 2.0",
    "total += (4.0)",
    "return (0.5 if rest else total)",
    "return total if rest else (1.0)",
}


def test_functions_are_changed_and_not_what_they_say() -> None:
    """Neither texts nor annotations, defaults, errors and the module's constants; each mutant is one line's."""
    found = mutants.mutants_of("faster.py", SOURCE)
    assert {each.lines(SOURCE)[1] for each in found} == CHANGED
    assert len(found) == len(CHANGED)
    for each in found:
        compile(each.applied(SOURCE), "faster.py", "exec")


def test_a_seed_draws_the_same_mutants_again() -> None:
    modules = sorted(ROOMS)[:3]
    first = mutants.sample(5, 1, modules)
    assert first == mutants.sample(5, 1, modules) != mutants.sample(5, 2, modules)
    assert {each.module for each in first} <= set(modules)


def test_rooms_and_arguments_are_of_what_is_there() -> None:
    for module, tests in ROOMS.items():
        assert (ROOT / module).is_file(), module
        assert all((ROOT / "tests" / file).is_file() for file in tests), module
    for (module, *lines), why in EQUIVALENT.items():
        source = (ROOT / module).read_text()
        known = [list(each.lines(source)) for each in mutants.mutants_of(module, source)]
        assert lines in known, f"{module} has no such mutant any more: {lines}"
        assert len(why.split()) > 4


@pytest.mark.slow  # starts some ten programs
def test_a_mutant_is_noticed_in_a_copy_that_is_then_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A project of one function and one test; without the mutant it passes, and is mended if it does not."""
    root = tmp_path / "root"
    (root / "tests").mkdir(parents=True)
    (root / "double.py").write_text("def double(x):\n    return x + x, x * 1\n")
    (root / "tests/test_double.py").write_text("from double import double\ndef test():\n    assert double(2)[0] == 4\n")
    (root / "pyproject.toml").write_text('[tool.pytest.ini_options]\npythonpath = ["."]\n')
    monkeypatch.setattr(mutants, "ROOT", root)
    monkeypatch.setattr(mutants, "COPIED", ("double.py", "tests", "pyproject.toml"))
    monkeypatch.setattr(mutants, "ROOMS", {"double.py": ("test_double.py",)})
    found = CliRunner().invoke(mutants.main, ["--count", "9"])
    assert found.exit_code == 1
    assert "noticed   double.py:2\n    - return x + x, x * 1\n    + return (x - x), x * 1" in found.output
    assert "SURVIVED  double.py:2\n    - return x + x, x * 1\n    + return x + x, (x / 1)" in found.output
    assert "noticed: 50% of 4 mutants of seed 0" in found.output
    why = "one divides as it multiplies"
    for changed in ("return x + x, (x / 1)", "return x + x, x * (0)"):
        monkeypatch.setitem(EQUIVALENT, ("double.py", "return x + x, x * 1", changed), why)
    argued = CliRunner().invoke(mutants.main, ["--count", "9"])
    assert argued.exit_code == 0
    assert why in argued.output
    assert "noticed: 100% of 4 mutants" in argued.output
    (root / "double.py").write_text("def double(x):\n    return x + 1\n")
    assert "test_double.py fails without any mutant" in CliRunner().invoke(mutants.main).output


@pytest.mark.slow
@pytest.mark.timeout(3600)  # s: some twelve minutes on two cores
def test_the_tests_notice_small_faults() -> None:
    """Of twenty mutants of the newer engines and laws; what survives is printed, and a test of it is missing."""
    found = list(mutants.verdicts(mutants.sample(20, 0, sorted(ROOMS)), workers=2))
    report = "\n".join(map(mutants.told, found))
    assert mutants.share(found) >= mutants.WANTED, report
