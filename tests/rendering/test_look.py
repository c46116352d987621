"""What is shown is told by names, and wrong names are answered with the right ones."""

import mujoco
import pytest

from mjbiped.errors import InputError
from mjbiped.rendering import ELEMENTS, look


def test_elements_and_flags_by_name() -> None:
    assert look().elements == set(ELEMENTS)
    assert look("ghost, chart").elements == set(ELEMENTS) - {"ghost", "chart"}
    assert look(["ghost", "chart,force"]).elements == set(ELEMENTS) - {"ghost", "chart", "force"}
    assert look("all").elements == set()
    chosen = look(flags=["contactpoint", "no-static,WIREFRAME"])
    assert chosen.visual == {mujoco.mjtVisFlag.mjVIS_CONTACTPOINT: True, mujoco.mjtVisFlag.mjVIS_STATIC: False}
    assert chosen.rendering == {mujoco.mjtRndFlag.mjRND_WIREFRAME: True}


def test_every_flag_of_mujoco_has_a_name_of_its_own() -> None:
    names = [
        name.partition("_")[2].lower()
        for kind in (mujoco.mjtVisFlag, mujoco.mjtRndFlag)
        for name in kind.__members__
        if not name.startswith("mjN")
    ]
    assert len(names) == len(set(names)) > 40
    for name in names:
        assert len(look(flags=name).visual) + len(look(flags=name).rendering) == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"hide": "torques"}, "unknown element to hide 'torques': valid are torque, force, .* did you mean 'torque'"),
        ({"hide": ["ghost", 3]}, "hide = .* must be names"),
        ({"hide": None}, "hide = None: must be names"),
        ({"flags": "fogg"}, "unknown visual flag 'fogg': valid are .*did you mean 'fog'"),
    ],
)
def test_refused_names(arguments: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        look(**arguments)  # type: ignore[arg-type]
