"""Mutants: what is changed where, that a sample is the same again, and, slowly, that the tests notice them."""

import pytest

from scripts import mutants
from scripts.mutants import EQUIVALENT, ROOT

SOURCE = '''"""What it is: 1 + 1."""

FACTOR = 2.0


def faster(speed: float = 1.0, *rest: int) -> float:
    """Not 1 - 1."""
    if speed < 0.0 and rest:
        raise ValueError(f"{speed - 1}")
    total = -speed + max(rest[0], 3)  # + é
    return total if rest else 0.5
'''

CHANGED = {
    "if (speed >= 0.0) and rest:",
    "if (speed < 0.0 or rest):",
    "total = (-speed - max(rest[0], 3))  # + é",
    "total = (-speed)  # + é",
    "total = (speed) + max(rest[0], 3)  # + é",
    "total = -speed + (min)(rest[0], 3)  # + é",
    "total = -speed + max(rest[(1)], 3)  # + é",
    "total = -speed + max(rest[0], (4))  # + é",
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


def test_rooms_and_arguments_are_of_what_is_there() -> None:
    for module in mutants.modules():
        assert all((ROOT / "tests" / tests).exists() for tests in mutants.tests_of(module)), module
    assert mutants.tests_of("mjbiped/engines/mujoco/step_size.py")[:3] == [
        "engines/mujoco/test_step_size.py",
        "engines/mujoco",
        "engines",
    ]
    for (module, *lines), why in EQUIVALENT.items():
        source = (ROOT / module).read_text()
        known = [list(each.lines(source)) for each in mutants.mutants_of(module, source)]
        assert lines in known, f"{module} has no such mutant any more: {lines}"
        assert len(why.split()) > 4


@pytest.mark.slow
@pytest.mark.timeout(3600)  # s: some twelve minutes on two cores
def test_the_tests_notice_small_faults() -> None:
    """Of twenty mutants of the newer engines and laws; what survives is printed, and a test of it is missing."""
    found = list(mutants.verdicts(mutants.sample(20, 0, mutants.modules()), workers=2))
    report = "\n".join(map(mutants.told, found))
    assert mutants.share(found) >= mutants.WANTED, report
