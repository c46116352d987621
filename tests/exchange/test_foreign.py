"""Robots from MJCF: our own exports read again, models of other hands, and what is refused: crashes and costs too."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

import mjbiped
from mjbiped.exchange import parts
from mjbiped.exchange.foreign import read_file, read_robot
from mjbiped.exchange.mjcf import export_scene

OURS = {
    "compass": mjbiped.Compass(),
    "moon": mjbiped.Compass(1 / 3, 0.7, 0.31, 0.5, 0.0123456789012345, 1.62),
    "point masses": mjbiped.Compass(leg_inertia=0.0, hip_mass=3.0),
    "kneed": mjbiped.KneedBiped(),
    "no hip mass": mjbiped.KneedBiped(shank_mass=1 / 7, hip_mass=0.0, shank_length=1 / 3, thigh_inertia=0.0),
}

# A compass on its stance foot, which is hinged to the world: it moves in the plane y-z, and its swing leg is drawn
# back. The mass of the hip is welded to the stance leg.
PINNED = """
<mujoco>
  <compiler angle="degree"/>
  <option gravity="0 0 -9.8"/>
  <worldbody>
    <geom type="plane" size="0 0 1"/>
    <body name="a" pos="0 2 0">
      <joint name="foot" type="hinge" axis="-1 0 0"/>
      <inertial pos="0 0 0.6" mass="4" diaginertia="0.3 0.25 0.1"/>
      <geom type="capsule" size="0.02" fromto="0 0 0 0 0 0.8"/>
      <body name="load" pos="0 0 0.8"><inertial pos="0 0 0" mass="6" diaginertia="1e-9 1e-9 1e-9"/></body>
      <body name="b" pos="0.1 0 0.8" euler="-30 0 0">
        <joint name="hip" type="hinge" axis="-1 0 0"/>
        <inertial pos="0 0 -0.2" euler="0 0 45" mass="4" diaginertia="0.2 0.4 0.3"/>
        <geom type="capsule" size="0.02" fromto="0 0 0 0 0 -0.8"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
PINNED_ROBOT = mjbiped.Compass(4.0, 6.0, 0.6, 0.2, 0.3, 9.8)

# A biped with knees that hangs by a hip, made of geoms with masses; y is the axis, and the shanks turn about -y.
LEG = """
      <body name="NAME" pos="0 ACROSS 0">
        <joint type="hinge" axis="0 1 0"/>
        <geom type="box" size="0.05 0.05 0.1" pos="0 0 -0.15" mass="3" contype="0" conaffinity="0"/>
        <body pos="0 0 -0.4">
          <joint type="hinge" axis="0 -1 0"/>
          <geom type="capsule" size="0.01" fromto="0 0 0 0 0 -0.5" mass="0" contype="0" conaffinity="0"/>
          <geom type="box" size="0.03 0.02 0.05" pos="0 0 -0.1" mass="0.7" contype="0" conaffinity="0"/>
          <geom name="NAME" type="sphere" size="0.02" pos="0 0 -0.5" mass="0"/>
        </body>
      </body>"""
KNEED = f"""
<mujoco>
  <worldbody>
    <body name="torso">
      <joint type="slide" axis="1 0 0"/> <joint type="slide" axis="0 0 1"/>
      <inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/>
      {LEG.replace("NAME", "one").replace("ACROSS", "0.1")}
      {LEG.replace("NAME", "other").replace("ACROSS", "-0.1")}
    </body>
  </worldbody>
</mujoco>
"""
INERTIAS = 3.0 * (0.05**2 + 0.1**2) / 3.0, 0.7 * (0.03**2 + 0.05**2) / 3.0
KNEED_ROBOT = mjbiped.KneedBiped(3.0, 0.7, 2.0, 0.4, 0.5, 0.15, 0.1, *INERTIAS)


def read(text: str, folder: Path) -> mjbiped.Compass | mjbiped.KneedBiped:
    file = folder / "model.xml"
    file.write_text(text, encoding="utf-8")
    return read_robot(file)


def numbers(robot: mjbiped.Compass | mjbiped.KneedBiped) -> list[float]:
    return [getattr(robot, name) for name in robot.numbers()]


@pytest.mark.parametrize("name", OURS)
def test_an_export_is_the_same_robot(name: str, tmp_path: Path) -> None:
    robot = OURS[name]
    export_scene(robot, mjbiped.Terrain.random(seed=1), tmp_path / "scene.xml", initial="rest")
    found = read_robot(tmp_path / "scene.xml")
    assert type(found) is type(robot)
    assert numbers(found) == pytest.approx(numbers(robot), rel=1e-12, abs=0.0)


def test_a_pinned_compass_of_other_names_and_axes(tmp_path: Path) -> None:
    robot = read(PINNED, tmp_path)
    assert numbers(robot) == pytest.approx(numbers(PINNED_ROBOT), rel=1e-8)  # the load has an inertia of 1e-9
    model = mujoco.MjModel.from_xml_string(PINNED)
    data, full = mujoco.MjData(model), np.zeros((2, 2))
    data.qpos[:] = 0.2, 0.5
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, full)
    absolute = np.array([[1.0, 0.0], [1.0, 1.0]])  # the swing leg's angle counts from the stance leg there
    q = [0.2, 0.2 + 0.5 + np.radians(30.0)]
    assert full == pytest.approx(absolute.T @ robot.mass_matrix(q) @ absolute, abs=2e-9)


def test_a_biped_with_knees_of_geoms(tmp_path: Path) -> None:
    robot = read(KNEED, tmp_path)
    assert isinstance(robot, mjbiped.KneedBiped)
    assert numbers(robot) == pytest.approx(numbers(KNEED_ROBOT), rel=1e-12)


def test_limits_of_motors_are_told(tmp_path: Path) -> None:
    """Of hinges, and of motors by force or control, whichever is less; a servo's control is no torque."""
    text = KNEED.replace('<joint type="hinge" axis="0 1 0"/>', '<joint name="h" type="hinge" axis="0 1 0" RANGE/>', 1)
    text = text.replace("RANGE", 'actuatorfrcrange="-30 20"').replace('axis="0 -1 0"', 'name="k" axis="0 -1 0"', 1)
    motors = """<actuator>
        <motor joint="h" gear="5" ctrlrange="-8 8"/>
        <motor name="m" joint="k" gear="-2" forcerange="-7 3" ctrlrange="-9 9"/>
        <position joint="k" kp="1" ctrlrange="-1 1"/>
      </actuator></mujoco>"""
    file = tmp_path / "model.xml"
    file.write_text(text.replace("</mujoco>", motors), encoding="utf-8")
    found = read_file(file)
    assert found.limits == {"hinge 'h'": 30.0, "motor 0": 40.0, "motor m": 14.0}
    assert numbers(found.robot) == pytest.approx(numbers(KNEED_ROBOT), rel=1e-12)


HINGE = '<joint type="hinge" axis="0 1 0"/>'
OTHER = '<body name="c"><joint axis="1 0 0"/><geom size="1"/></body>'
FOOT = 'name="other" type="sphere" size="0.02"'
REFUSED = {
    "losses": (KNEED.replace("<joint type", '<joint damping="0.5" type', 1), r"it has damping \(0.5\).*set it to 0"),
    "free": (PINNED.replace('type="hinge"', 'type="free"', 1).replace('axis="-1 0 0"/>', "/>", 1), "'a' has a free or"),
    "across": (KNEED.replace('axis="0 -1 0"', 'axis="1 0 0"', 1), "leads out of the plane"),
    "no gravity": (PINNED.replace("-9.8", "0"), "no gravity"),
    "trunk": (KNEED.replace('axis="0 0 1"/>', f'axis="0 0 1"/>{HINGE}', 1), "expected no trunk"),
    "unequal": (KNEED.replace('mass="3"', 'mass="3.5"', 1), "legs are not equal: mass 3.5 of the body 'one', and 3 of"),
    "two trees": (PINNED.replace("</worldbody>", f"{OTHER}</worldbody>"), "the body 'c' hang on the world apart"),
    "beside": (KNEED.replace('pos="0 0 -0.15"', 'pos="0.02 0 -0.15"'), "'one' lies 0.02 m beside the line"),
    "no feet": (KNEED.replace(FOOT, FOOT.replace("sphere", "box").replace("0.02", "1 1 1")), "has no foot"),
    "no MJCF": ("<mujoco><robot/></mujoco>", "MuJoCo cannot read it: XML Error"),
}


FIRST = [*REFUSED][:4]  # each compiles in a process of its own: the others are slow


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name in FIRST else pytest.mark.slow) for name in REFUSED]
)
def test_says_what_is_missing(name: str, tmp_path: Path) -> None:
    text, message = REFUSED[name]
    assert text not in (KNEED, PINNED)
    with pytest.raises(mjbiped.InputError, match=message) as raised:
        read(text, tmp_path)
    assert "model.xml': " in str(raised.value)
    assert len(str(raised.value).splitlines()) == 1


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
    "SIGSEGV": ('<asset><model name="m" file="model.xml"/></asset>', '<attach model="m" body="a" prefix="p"/>'),
    "has not come to an end": ("", '<replicate count="1000000"><geom size="0.1"/></replicate>'),
}


@pytest.mark.parametrize("words", GREAT)
def test_a_crash_and_the_limits_are_told(words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    head, world = GREAT[words]
    if not head:
        monkeypatch.setattr(parts, "_LONGEST", 1)  # s; it takes minutes
    with pytest.raises(mjbiped.InputError, match=words) as raised:
        read(MODEL.format(head=head, world=world), tmp_path)
    assert "GiB of memory; expected the model of a robot alone" in str(raised.value)
    assert len(str(raised.value).splitlines()) == 1
