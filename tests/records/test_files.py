"""Records on disk: what comes back, and what is refused of a file that may come from anyone, and at what cost."""

import dataclasses
import io
import json
import math
import os
import struct
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from walk_cases import Rude

import mjbiped
from controllers import AdaptiveController
from mjbiped import RecordError, Walk
from mjbiped.plotting.walk import plot_walk
from mjbiped.records import measures
from mjbiped.records.arrays import LONGEST_HEADER, MOST_MEMBERS, parsed, read_arrays, write_arrays
from mjbiped.records.schema import ADDED, FORMAT_VERSION

# ---- archives --------------------------------------------------------------------------------------------------------


def array_file(array: np.ndarray, header: str = "") -> bytes:
    """An .npy file, with another header where one is given."""
    stream = io.BytesIO()
    np.save(stream, array)
    if not header:
        return stream.getvalue()
    text = header.encode() + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text + array.tobytes()


def archive_of(path: Path, *contents: bytes) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for number, content in enumerate(contents):
            archive.writestr(f"{number:0>40}.npy", content)
    return path


def test_numbers_and_texts_come_back(tmp_path: Path) -> None:
    path = tmp_path / "arrays.npz"
    given: dict[str, Any] = {
        "floats": np.arange(6.0).reshape(2, 3),
        "other_order": np.asfortranarray(np.arange(6.0).reshape(2, 3)),
        "other_end": np.arange(3.0).astype(">f8"),
        "whole": np.random.default_rng(0).integers(0, 1 << 62, 140_000),  # longer than a directory may be
        "text": np.array("some text"),
        "none": np.empty((0, 2)),
    }
    for save in (np.savez, lambda path, **arrays: write_arrays(path, arrays)):
        save(path, **given)
        found = read_arrays(path)
        assert found.keys() == given.keys()
        for name, array in given.items():
            np.testing.assert_array_equal(found[name], array)
            assert found[name].dtype.isnative
            assert found[name].flags.writeable


SHAPES = ("(962072674304,)", "(1099511627776, 8)", "(-1,)", "(5,)", f"({10**400},)")
TYPES = ("<f4", "|O", "<c16", "<M8[s]", "|V8", "<U3")
UNREADABLE = ("{", "[" * 1000, "(" * 60 + ")" * 60, "{'descr': 3}", "x" * 20_000, "'a': 0L,")


@pytest.mark.parametrize(
    "header",
    [
        *(f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}" for shape in SHAPES),
        *(f"{{'descr': '{descr}', 'fortran_order': False, 'shape': (3,), }}" for descr in TYPES),
        *UNREADABLE,
    ],
)
def test_headers_are_judged_before_anything_is_allocated(header: str, tmp_path: Path) -> None:
    """A header that claimed 7 TiB ended in a MemoryError."""
    path = archive_of(tmp_path / "odd.npz", array_file(np.zeros(3), header))
    tracemalloc.start()
    try:
        with pytest.raises(RecordError, match="no walk's record"):
            read_arrays(path)
        assert tracemalloc.get_traced_memory()[1] < 1 << 20
    finally:
        tracemalloc.stop()


def test_claimed_sizes_of_members_are_compared_with_the_file(tmp_path: Path) -> None:
    path = archive_of(tmp_path / "huge.npz", array_file(np.zeros(3)))
    content = bytearray(path.read_bytes())
    entry = content.rindex(b"PK\x01\x02")
    content[entry + 24 : entry + 28] = struct.pack("<I", 0xFFFFFFFE)  # the size unpacked, in the archive's directory
    path.write_bytes(content)
    with pytest.raises(RecordError, match="claims to hold 4294967294 bytes"):
        read_arrays(path)


def test_archives_of_many_members_are_refused(tmp_path: Path) -> None:
    """Some 20 000 arrays of one number each took longer to read than any walk."""
    one, path = array_file(np.zeros(1)), tmp_path / "many.npz"
    assert len(read_arrays(archive_of(path, *[one] * MOST_MEMBERS))) == MOST_MEMBERS
    with pytest.raises(RecordError, match="a record has at most 256"):
        read_arrays(archive_of(path, *[one] * (MOST_MEMBERS + 1)))
    with zipfile.ZipFile(path, "w") as archive:
        for number in range(300):  # names of 4 kB fill a directory of more than 1 MiB
            archive.writestr(f"{number:04000}.npy", b"")
    with pytest.raises(RecordError, match=r"its directory has \d+ bytes; a record has at most 256 arrays"):
        read_arrays(path)


def test_devices_and_pipes_are_not_read(tmp_path: Path) -> None:
    """One gives bytes without end (23 GB were read once), the other waits for someone to write."""
    pipe = tmp_path / "walk.npz"
    os.mkfifo(pipe)
    for path in (Path("/dev/zero"), pipe):
        with pytest.raises(RecordError, match=f"{path}: is a device or a pipe; expected a file"):
            read_arrays(path)


# ---- records ---------------------------------------------------------------------------------------------------------


def test_settings_of_a_loaded_record_repeat_the_walk(controller: AdaptiveController, tmp_path: Path) -> None:
    """A walk built from the file alone is bitwise the same."""
    walk = mjbiped.walk(controller, mjbiped.Terrain.mixed(), steps=3, initial="rest")
    walk.save(tmp_path / "walk.npz")
    loaded = Walk.load(tmp_path / "walk.npz")
    assert (loaded, loaded.robot, loaded.terrain, loaded.steps) == (walk, walk.robot, walk.terrain, 3)
    settings = loaded.settings
    description = dict(settings["controller"])
    assert description.pop("name") == "AdaptiveController"
    robot, imitated = mjbiped.Compass(**description.pop("robot")), description.pop("gait")
    gait = mjbiped.find_passive_gait(mjbiped.Compass(**imitated["robot"]), imitated["slope"])
    of_engine = ("timestep", "contact_timestep", "control_period", "ground", "lands")
    again = mjbiped.walk(
        AdaptiveController(robot, gait, **description),
        mjbiped.Terrain.from_dict(settings["terrain"]),
        engine=mjbiped.Mujoco(**{name: settings[name] for name in of_engine}),
        robot=mjbiped.Compass(**settings["robot"]),
        scuffing=mjbiped.ScuffingRule(**settings["scuffing"]),
        **{name: settings[name] for name in ("steps", "distance", "initial", "sample_period")},
    )
    assert again == walk


def test_equality_sees_every_part(walk: Walk) -> None:
    for parts in (
        {"samples": {**walk.samples, "q": walk.samples["q"] + 1e-12}},
        {"touchdowns": {**walk.touchdowns, "x": walk.touchdowns["x"] + 1e-12}},
        {"peak_torque": walk.peak_torque + 1e-12},
        {"settings": {**walk.settings, "timestep": 1.0}},
        {"outcome": "fell"},
        {"end": (0.0, 0.0)},
    ):
        assert dataclasses.replace(walk, **parts) != walk
    assert dataclasses.replace(walk, settings={**walk.settings, "command": "mjbiped walk"}) == walk


def test_files_that_are_no_records(walk: Walk, tmp_path: Path) -> None:
    path = tmp_path / "walk.npz"
    walk.save(path)
    content = path.read_bytes()
    other = archive_of(path, array_file(np.zeros(3))).read_bytes()
    for wrong in (b"", content[: len(content) // 3], content[:-9], b"not an archive", array_file(np.zeros(3)), other):
        path.write_bytes(wrong)
        with pytest.raises(RecordError, match="no walk's record"):
            Walk.load(path)
    for refused, message in (
        (lambda: Walk.load(tmp_path / "nothing.npz"), "there is no such file"),
        (lambda: Walk.load(tmp_path), "is a folder"),
        (lambda: walk.save(tmp_path / "no folder" / "walk.npz"), "cannot write"),
        (lambda: walk.save(tmp_path / "walk.csv"), r"\.npz"),
    ):
        with pytest.raises(RecordError, match=message):
            refused()


class Parts:
    """What a record's file is made of."""

    def __init__(self, walk: Walk, path: Path) -> None:
        walk.save(path)
        with np.load(path) as file:
            self.arrays: dict[str, Any] = {name: file[name] for name in file.files}
        self.header = json.loads(str(self.arrays["header"]))

    @property
    def settings(self) -> Any:
        return self.header["settings"]

    def put(self, name: str, change: Callable[[np.ndarray], np.ndarray]) -> None:
        self.arrays[name] = change(self.arrays[name])

    def loaded(self, path: Path) -> Walk:
        np.savez(path, **{**self.arrays, "header": np.array(json.dumps(self.header))})
        return Walk.load(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda r: r.header.update(outcome="walking"), "outcome is 'walking'; expected one of finished, fell"),
        (lambda r: r.header.update(end=[0.0, math.nan]), "a time and a place"),
        (lambda r: r.header.update(version=FORMAT_VERSION + 1), "newer"),
        (lambda r: r.header.update(settings=[]), "expected a table"),
        (lambda r: r.settings.pop("robot"), "lack 'robot'"),
        (lambda r: r.settings["terrain"].update(x=[1.0]), "terrain cannot be built"),
        (lambda r: r.settings.update(controller="x"), "a table with a name"),
        (lambda r: r.settings.update(initial=[0.0, 0.0, 0.0]), "4 numbers"),
        (lambda r: r.settings.update(warnings={"a": 0}), "numbers of times"),
        (lambda r: r.settings.update(scuffing={"legs": 2}), "scuffing rule cannot be built"),
        (lambda r: r.settings.update(unfinished_step={"slip": 0.0}), "numbers for slip, friction"),
        (lambda r: r.settings.update(controller_source={"class": "a.py:B", "sha256": 1}), "a class and the digest"),
        (lambda r: r.settings.update(more="x" * LONGEST_HEADER), "too long"),
        (lambda r: r.put("samples/q", lambda column: column[:, :1]), r"samples/q .*floats of shape \(2,\) a row"),
        (lambda r: r.put("samples/stance", lambda column: column + 1), "samples/stance .*whole ones from 0 to 1"),
        (lambda r: r.put("touchdowns/q", lambda column: column * math.nan), "touchdowns/q .*finite"),
        (lambda r: r.put("samples/qpos", lambda column: column * 1e12), "samples/qpos .*none beyond"),
        (lambda r: r.put("samples/time", lambda column: column[::-1]), "ascend"),
        (lambda r: r.put("pressure_times", lambda times: times - 1.0), "no time"),
        (lambda r: r.arrays.pop("touchdowns/contact_force"), "incomplete record: it lacks touchdowns/contact_force"),
        (lambda r: r.arrays.update(peak_torque=np.zeros(3)), "peak_torque"),
        (lambda r: r.arrays.update({"samples/more": np.zeros(2)}), "samples/'more'.* rows of numbers"),
    ],
)  # fmt: skip
def test_damaged_records_are_refused(walk: Walk, tmp_path: Path, change: Any, message: str) -> None:
    parts = Parts(walk, tmp_path / "walk.npz")
    change(parts)
    with pytest.raises(RecordError, match=message):
        parts.loaded(tmp_path / "walk.npz")


def test_further_columns_and_settings_that_readers_only_show_stay(walk: Walk, tmp_path: Path) -> None:
    more = {**walk.touchdowns, "clearance": np.arange(float(walk.steps))}
    shown = {**walk.settings, "engine": "mine", "tolerance": "tight", "steps": None}
    own = dataclasses.replace(walk, touchdowns=more, settings=shown)
    own.save(tmp_path / "walk.npz")
    assert Walk.load(tmp_path / "walk.npz") == own


@pytest.mark.parametrize("walker", ["walk", "kneed"])
@pytest.mark.parametrize("version", ADDED)
def test_a_version_is_read(version: int, walker: str, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    walk: Walk = request.getfixturevalue(walker)
    parts = Parts(walk, tmp_path / "walk.npz")
    later = {name for since, names in ADDED.items() if since > version for name in names}
    parts.arrays = {name: array for name, array in parts.arrays.items() if name not in later}
    parts.header["version"] = version
    old = parts.loaded(tmp_path / "walk.npz")
    for kind in ("samples", "touchdowns"):
        found, expected = getattr(old, kind), getattr(walk, kind)
        assert found.keys() == expected.keys()
        for name, column in expected.items():
            new = f"{kind}/{name}" in later
            np.testing.assert_array_equal(found[name], np.full_like(column, math.nan) if new else column)
    assert np.isnan(old.pressure_times).all() == (version < 4)
    assert (old.summary()["foot_length_99_percent_m"] is None) == (version < 4)
    assert old.summary()["cost_of_transport"] == walk.summary()["cost_of_transport"]


@pytest.mark.parametrize("engine", ["mujoco", "hybrid"])
@pytest.mark.parametrize("law", [Rude(4, 0.0, 0.1), Rude(0, 1e9, 0.1), Rude(1, 1e300, 0.1)])
def test_whatever_an_engine_records_can_be_loaded_and_drawn(engine: str, law: Rude, tmp_path: Path) -> None:
    walk = mjbiped.walk(law, mjbiped.Terrain.incline(2.0), engine=engine, steps=2, sample_period=0.02)
    walk.save(tmp_path / "walk.npz")
    again = Walk.load(tmp_path / "walk.npz")
    assert again == walk
    measures.summary(again)
    plot_walk(again)


def test_texts_nested_without_end_are_refused() -> None:
    assert parsed("[" * 41 + "]" * 41)
    with pytest.raises(ValueError, match="nested more than 40 times"):
        parsed("[" * 60 + "]" * 60)
