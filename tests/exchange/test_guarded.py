"""Models that would crash MuJoCo, keep it busy, or fill the memory: each is refused in one sentence."""

from __future__ import annotations

from pathlib import Path

import pytest

from mjbiped.errors import InputError
from mjbiped.exchange import parts
from mjbiped.exchange.foreign import read_robot

MODEL = """
<mujoco>
  <compiler meshdir="parts"/>
  {head}
  <worldbody>
    {world}
    <body name="a"><joint axis="0 1 0"/><geom size="0.1"/></body>
  </worldbody>
</mujoco>
"""
GREAT = {
    "crash": (
        '<asset><model name="m" file="model.xml"/></asset>',
        '<attach model="m" body="a" prefix="p"/>',
        "SIGSEGV",
    ),
    "memory": (
        '<asset><hfield name="h" nrow="40000" ncol="40000" size="1 1 1 1"/></asset>',
        '<geom type="hfield" hfield="h"/>',
        "ends with RuntimeError: ",
    ),
    "time": ("", '<replicate count="1000000"><geom size="0.1"/></replicate>', "has not come to an end"),
}


def refused(folder: Path, head: str, world: str = "") -> str:
    """What a model is refused with."""
    (folder / "model.xml").write_text(MODEL.format(head=head, world=world), encoding="utf-8")
    with pytest.raises(InputError) as raised:
        read_robot(folder / "model.xml")
    message = str(raised.value)
    assert message.startswith(repr(str(folder / "model.xml"))[:20])
    assert len(message.splitlines()) == 1
    return message


@pytest.mark.parametrize("name", GREAT)
def test_a_crash_and_the_limits_are_told(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    head, world, words = GREAT[name]
    if name == "time":
        monkeypatch.setattr(parts, "_LONGEST", 1)  # s; it takes minutes
    message = refused(tmp_path, head, world)
    assert words in message
    assert "GiB of memory; expected the model of a robot alone" in message
