"""The record on disk."""

import dataclasses
import json
import math
import zipfile
from pathlib import Path

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController
from mjbiped.records.columns import SAMPLES, TOUCHDOWNS
from mjbiped.records.record import Walk
from mjbiped.records.schema import FORMAT, FORMAT_VERSION


@pytest.fixture(scope="module")
def walk(controller: AdaptiveController) -> Walk:
    return mjbiped.walk(controller, mjbiped.Terrain.mixed(), steps=3, initial="rest")


@pytest.fixture
def saved(walk: Walk, tmp_path: Path) -> Path:
    path = tmp_path / "walk.npz"
    walk.save(path)
    return path


def test_round_trip_is_bitwise(walk: Walk, saved: Path) -> None:
    again = Walk.load(saved)
    assert again == walk
    assert again.robot == walk.robot
    assert again.terrain == walk.terrain
    assert again.steps == 3


def test_equality_sees_every_part(walk: Walk, saved: Path) -> None:
    loaded = Walk.load(saved)
    for parts in (
        {"samples": {**loaded.samples, "q": loaded.samples["q"] + 1e-12}},
        {"touchdowns": {**loaded.touchdowns, "x": loaded.touchdowns["x"] + 1e-12}},
        {"peak_torque": loaded.peak_torque + 1e-12},
        {"settings": {**loaded.settings, "timestep": 1.0}},
        {"outcome": "fell"},
        {"end": (0.0, 0.0)},
    ):
        assert dataclasses.replace(loaded, **parts) != walk
    assert walk != "a walk"


def test_a_walk_shows_itself_in_one_line(walk: Walk) -> None:
    assert repr(walk).startswith("<Walk on mixed: finished after 3 steps, ")


def test_tables_have_their_columns(walk: Walk) -> None:
    assert set(walk.samples) == {*SAMPLES, "controller_states"}
    assert set(walk.touchdowns) == set(TOUCHDOWNS)
    n = len(walk.samples["time"])
    for name, column in SAMPLES.items():
        assert walk.samples[name].shape == ((n, column.width) if column.width > 1 else (n,))
    for name, column in TOUCHDOWNS.items():
        assert walk.touchdowns[name].shape == ((3, column.width) if column.width > 1 else (3,))


def test_settings_repeat_the_walk(walk: Walk, saved: Path) -> None:
    """All that is needed: a walk built from the file alone is bitwise the same."""
    settings = Walk.load(saved).settings
    description = dict(settings["controller"])
    assert description.pop("name") == "AdaptiveController"
    robot = mjbiped.Compass(**description.pop("robot"))
    imitated = description.pop("gait")
    gait = mjbiped.find_passive_gait(mjbiped.Compass(**imitated["robot"]), imitated["slope"])
    again = mjbiped.walk(
        AdaptiveController(robot, gait, **description),
        mjbiped.Terrain.from_dict(settings["terrain"]),
        engine=mjbiped.Mujoco(
            **{name: settings[name] for name in ("timestep", "contact_timestep", "control_period", "ground", "lands")}
        ),
        steps=settings["steps"],
        distance=settings["distance"],
        initial=settings["initial"],
        robot=mjbiped.Compass(**settings["robot"]),
        sample_period=settings["sample_period"],
        scuffing=mjbiped.ScuffingRule(**settings["scuffing"]),
    )
    assert again == walk


@pytest.mark.parametrize("part", [0.0, 0.3, 0.9, 0.999])
def test_truncated_file_is_refused(part: float, saved: Path) -> None:
    content = saved.read_bytes()
    saved.write_bytes(content[: int(len(content) * part)])
    with pytest.raises(mjbiped.RecordError, match="no walk's record"):
        Walk.load(saved)


def test_foreign_files_are_refused(tmp_path: Path) -> None:
    plain = tmp_path / "plain.npz"
    np.savez(plain, a=np.zeros(3))
    text = tmp_path / "text.npz"
    text.write_text("not an archive")
    other = tmp_path / "other.npz"
    np.savez(other, header=np.array(json.dumps({"format": "other thing", "version": 1})))
    archive = tmp_path / "archive.npz"
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr("readme.txt", "no arrays here")
    pickled = tmp_path / "pickled.npz"
    np.savez(pickled, header=np.array([{"format": FORMAT}], dtype=object))
    single = tmp_path / "single.npz"
    with single.open("wb") as stream:
        np.save(stream, np.zeros(3))
    for path in (single, plain, text, other, archive, pickled):
        with pytest.raises(mjbiped.RecordError, match="no walk's record"):
            Walk.load(path)


def test_newer_version_is_refused(saved: Path) -> None:
    with np.load(saved) as file:
        arrays = {name: file[name] for name in file.files}
    header = json.loads(str(arrays["header"]))
    arrays["header"] = np.array(json.dumps({**header, "version": FORMAT_VERSION + 1}))
    np.savez(saved, **arrays)
    with pytest.raises(mjbiped.RecordError, match="newer"):
        Walk.load(saved)


def test_missing_file_and_folder(walk: Walk, tmp_path: Path) -> None:
    with pytest.raises(mjbiped.RecordError, match="there is no such file"):
        Walk.load(tmp_path / "nothing.npz")
    with pytest.raises(mjbiped.RecordError, match="cannot write"):
        walk.save(tmp_path / "no folder" / "walk.npz")
    with pytest.raises(mjbiped.RecordError, match=r"\.npz"):
        walk.save(tmp_path / "walk.csv")


def test_failed_save_leaves_the_old_file(walk: Walk, saved: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(path: Path, **arrays: object) -> None:
        path.write_bytes(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez_compressed", fail)
    with pytest.raises(mjbiped.RecordError, match="No space left"):
        walk.save(saved)
    assert Walk.load(saved) == walk
    assert [path.name for path in saved.parent.iterdir()] == ["walk.npz"]


def test_walk_without_touchdowns(tmp_path: Path) -> None:
    from controllers import PassiveController

    walk = mjbiped.walk(PassiveController(), mjbiped.Terrain.level(), initial=(-0.3, 0.3, 0.0, 0.0))
    assert (walk.steps, walk.distance) == (0, 0.0)
    assert math.isnan(walk.cost_of_transport)
    walk.save(tmp_path / "walk.npz")
    assert Walk.load(tmp_path / "walk.npz") == walk
