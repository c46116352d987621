"""An interpreted walk and the same walk as machine code have the same record, to the last bit.

200 walks: robots, laws, engines and grounds, some in a disturbed loop. The quick tests compile for two robots and two
laws.
"""

from collections.abc import Iterator
from typing import Any

import pytest
from golden_walks import DISTURBED, GROUNDS, ROBOTS

import mjbiped
from mjbiped.control.registry import make_controller
from mjbiped.engines.compiling import VARIABLE

COMPARISON = ("passivity", "energy-constraint", "kinetic-energy", "limit-cycle")
LAWS = {
    "compass": ("adaptive", "passive", "library", "policy", *COMPARISON),
    "sole": ("adaptive", "bounded-ankle", "supervised"),
    "kneed": ("adaptive", "passive"),
    "kneed on soles": ("adaptive", "bounded-ankle"),
    "footed": ("bounded-ankle", "supervised"),
    "round": ("passive",),
    "round kneed": ("passive",),
    "wheel": ("passive",),
}
PLANES = ("level", "2 down", "3 down", "3 up")
UNEVEN = ("mixed", "downstairs", "upstairs", "random", "early riser")
QUICK = {
    ("hybrid", "compass", "adaptive", "upstairs", ""),
    ("hybrid", "compass", "passive", "3 down", ""),
    ("mujoco", "compass", "adaptive", "mixed", "disturbed"),
    ("mujoco", "kneed", "passive", "3 down", ""),
}


def cases() -> Iterator[Any]:
    for robot, laws in LAWS.items():
        for law in laws:
            for ground in PLANES if ROBOTS[robot].radius else (*PLANES, *UNEVEN):
                for disturbed in ("", "disturbed") if ground == "mixed" else ("",):
                    for engine in ("hybrid", "mujoco"):
                        case = engine, robot, law, ground, disturbed
                        mark = pytest.mark.compiled if case in QUICK else (pytest.mark.slow, pytest.mark.compiled)
                        yield pytest.param(*case, marks=mark, id="-".join(filter(None, case)))


@pytest.mark.parametrize(("engine", "robot", "law", "ground", "disturbed"), [*cases()])
def test_both_ways_make_the_same_walk(
    engine: str, robot: str, law: str, ground: str, disturbed: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    controller = make_controller(law, ROBOTS[robot], {})
    found: list[mjbiped.Walk | str] = []
    for way in ("never", "always"):
        monkeypatch.setenv(VARIABLE, way)
        try:
            found.append(
                mjbiped.walk(
                    controller,
                    GROUNDS[ground],
                    engine=engine,
                    robot=ROBOTS[robot],
                    steps=2 if robot == "footed" else 4,
                    initial="rest" if law == "passive" and "down" not in ground else "gait",
                    disturbances=DISTURBED if disturbed else None,
                )
            )
        except mjbiped.MjbipedError as error:  # such as no gait on this ground
            found.append(str(error))
    assert found[0] == found[1]
