"""Damaged records, thousands of them: each is refused by a `RecordError` in words, or can be measured and drawn.

A case is a number, which seeds everything; `make test` tries the first few, `make test-slow` all.
"""

import copy
import io
import json
import math
import random
import re
import zipfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pytest
from time_limits import within

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.analysis.stability import stability
from mjbiped.errors import RecordError
from mjbiped.plotting.walk import plot_walk
from mjbiped.records import measures
from mjbiped.records.record import Walk
from mjbiped.records.schema import FORMAT_VERSION
from mjbiped.rendering.gl import gl_available
from mjbiped.rendering.video import render_frame
from mjbiped.reports.page import flattened

Members: TypeAlias = dict[str, bytes]
"""The members of a record's archive."""

FEW, MANY = 150, 4000
LONGEST = 20.0  # s for one case, of which the slowest good one takes 1 s on a machine at rest
LONGEST_MESSAGE = 700  # characters: a path, and what is wrong

NASTY: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 2, 3.5, -0.0, 1e308, -1e308, 1e-308, math.nan, math.inf, -math.inf, 10**30, 10**400,
    "", "x", "rest", "mixed", "finished", "\ud800", "\0", "$x^2$", "a\nb", "x" * 5000, [], {}, [[]], [1.0], [0.0, 0.0],
    [1, 2, 3], [math.nan] * 2, ["a"] * 4, {"name": "x"}, {"x": 1}, [[[[[[[[[[[[]]]]]]]]]]]],
)  # fmt: skip
DTYPES = ("<f8", ">f8", "<f4", "<i8", "<i4", "|b1", "<U7", "|S3", "<c16", "<M8[s]", "|O", "|V8", "<f2", "<u8", "<U0")
SHAPES = (
    "()", "(0,)", "(1,)", "(2,)", "(-1,)", "(3, 2)", "(7, 0)", "(1099511627776,)", "(962072674304, 8)", "(1, 1, 1, 1)",
    "('a',)", "None", "5", "(True,)", "(" * 60 + ")" * 60, f"({10**30},)", f"({'9' * 300},)",
)  # fmt: skip


@pytest.fixture(scope="module")
def records(controller: AdaptiveController, tmp_path_factory: pytest.TempPathFactory) -> list[bytes]:
    """Sound records: of both engines, of walks and falls, with and without samples."""
    level = mjbiped.Terrain.level()
    walks = [
        mjbiped.walk(controller, mjbiped.Terrain.mixed(), steps=2, initial="rest", sample_period=0.02),
        mjbiped.walk(controller, mjbiped.Terrain.mixed(), engine="hybrid", steps=3, sample_period=0.01),
        mjbiped.walk(controller, level, engine="hybrid", steps=2, sample_period=None),
        mjbiped.walk(PassiveController(), level, initial=(-0.3, 0.3, 0.0, 0.0), sample_period=0.05),
    ]
    path = tmp_path_factory.mktemp("records") / "walk.npz"
    contents = []
    for walk in walks:
        walk.save(path)
        contents.append(path.read_bytes())
    return contents


# ---- taking records apart and putting them together ------------------------------------------------------------------


def members_of(content: bytes) -> Members:
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def packed(members: Members, compression: int = zipfile.ZIP_DEFLATED) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", compression) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return stream.getvalue()


def array_of(content: bytes) -> np.ndarray:
    return np.asarray(np.load(io.BytesIO(content)))


def bytes_of(array: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.save(stream, array, allow_pickle=True)
    return stream.getvalue()


def places_of(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Where something stands in nested JSON."""
    items = value.items() if isinstance(value, dict) else enumerate(value[:4]) if isinstance(value, list) else ()
    return [path, *(place for key, part in items for place in places_of(part, (*path, key)))]


# ---- damages ---------------------------------------------------------------------------------------------------------


def flip_bytes(draw: random.Random, content: bytes) -> bytes:
    changed = bytearray(content)
    for _ in range(draw.choice((1, 1, 2, 5, 30))):
        changed[draw.randrange(len(changed))] = draw.randrange(256)
    return bytes(changed)


def flip_directory(draw: random.Random, content: bytes) -> bytes:
    """Bytes at the end, where the archive says what is in it and how large."""
    changed = bytearray(content)
    for _ in range(draw.choice((1, 2, 4))):
        changed[-draw.randrange(1, 1500)] = draw.choice((0, 1, 255, draw.randrange(256)))
    return bytes(changed)


def cut_bytes(draw: random.Random, content: bytes) -> bytes:
    first, last = sorted(draw.randrange(len(content)) for _ in range(2))
    part = content[first:last]
    return draw.choice((content[:first], content[first:], content[:first] + content[last:], content[:last] + part))


def change_members(draw: random.Random, content: bytes) -> bytes:
    members = members_of(content)
    one, other = draw.sample(list(members), 2)
    action = draw.randrange(8)
    if action == 0:
        del members[one]
    elif action == 1:
        members[one] = members[other]
    elif action == 2:
        members[draw.choice(("x.npy", "samples/.npy", "samples/a/b.npy", "touchdowns/", "../x.npy"))] = members.pop(one)
    elif action == 3:
        members[one] = draw.choice((b"", b"\x93NUMPY", draw.randbytes(50), members[one][: len(members[one]) // 2]))
    elif action == 4:
        members[one] += draw.randbytes(draw.choice((1, 8, 1000)))
    elif action == 5:
        return packed(members, draw.choice((zipfile.ZIP_STORED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA)))
    elif action == 6:  # twice the same name
        return packed(members).replace(other.encode(), one.encode().ljust(len(other), b"_")[: len(other)])
    else:
        members = dict(draw.sample(list(members.items()), len(members)))
    return packed(members)


def change_array_header(draw: random.Random, content: bytes) -> bytes:
    members = members_of(content)
    name = draw.choice(list(members))
    text = members[name][10:].partition(b"\n")[0].decode("latin-1")
    if draw.random() < 0.5:
        text = re.sub(r"'descr': '[^']*'", lambda _: f"'descr': '{draw.choice(DTYPES)}'", text)
    if draw.random() < 0.5:
        text = re.sub(r"'shape': \([^)]*\)", lambda _: f"'shape': {draw.choice(SHAPES)}", text)
    if draw.random() < 0.2:
        text = draw.choice(
            ("", "{", "[" * 9000, "{'descr': [('a', '<f8', (99999999, 99999999))]}", text.replace(" ", ""))
        )
    if draw.random() < 0.2:
        text = text.replace("False", draw.choice(("True", "None", "L", "0L")))
    data = members[name].partition(b"\n")[2]
    version = draw.choice((b"\x01\x00", b"\x01\x00", b"\x01\x00", b"\x02\x00", b"\x03\x00", b"\x09\x09"))
    written = text.rstrip().encode("latin-1") + b"\n"
    size = len(written).to_bytes(2 if version == b"\x01\x00" else 4, "little")
    members[name] = b"\x93NUMPY" + version + size + written + data
    return packed(members)


def change_array(draw: random.Random, content: bytes) -> bytes:
    members = members_of(content)
    name = draw.choice([name for name in members if name != "header.npy"])
    array = array_of(members[name]).copy()
    changes: list[Callable[[], Any]] = [
        lambda: array.astype(draw.choice(("f4", "i4", "i8", "c16", ">f8", "bool", "U5", "f8"))),
        lambda: array.astype(object),
        lambda: array.reshape(-1),
        lambda: array[..., None],
        lambda: array[: len(array) // 2],
        lambda: np.concatenate([array, array]),
        lambda: np.asfortranarray(array),
        lambda: array[::-1],
        lambda: np.zeros_like(array),
        lambda: array * draw.choice((-1, 2, 10, 10**6, 10**12)),
    ]
    if array.size and array.dtype.kind == "f" and draw.random() < 0.5:
        flat = array.reshape(-1)
        for _ in range(draw.choice((1, 1, 3, 20))):
            value = draw.choice((math.nan, math.inf, -math.inf, 0.0, -1.0, 1e3, 1e6, 9e9, 1e12, 1e100, -1e300, 5e-324))
            flat[draw.randrange(flat.size)] = value
        changed = array
    elif array.size and array.dtype.kind == "i" and draw.random() < 0.5:
        array.reshape(-1)[draw.randrange(array.size)] = draw.choice((-1, 2, 3, 2**40, -(2**63)))
        changed = array
    else:
        with np.errstate(all="ignore"):
            changed = draw.choice(changes)()
    members[name] = bytes_of(changed)
    return packed(members)


def change_header(draw: random.Random, content: bytes) -> bytes:
    members = members_of(content)
    header = json.loads(str(array_of(members["header.npy"])))
    for _ in range(draw.choice((1, 1, 2))):
        header = copy.deepcopy(header)
        path = draw.choice(places_of(header))
        if not path:
            header = draw.choice((header, draw.choice(NASTY)))
            continue
        *outer, last = path
        part = header
        for key in outer:
            part = part[key]
        action = draw.randrange(4)
        if action == 0:
            del part[last]
        elif action == 1 and isinstance(part, dict):
            part[draw.choice(("extra", "name", "x", "robot"))] = draw.choice(NASTY)
        else:
            part[last] = draw.choice(NASTY)
        if not isinstance(header, dict):
            break
    text = json.dumps(header)
    members["header.npy"] = bytes_of(np.array(text))
    return packed(members)


def replace_header(draw: random.Random, content: bytes) -> bytes:
    members = members_of(content)
    text = str(array_of(members["header.npy"]))
    members["header.npy"] = bytes_of(
        draw.choice(
            (
                np.array("[" * 100_000),
                np.array('{"a":' * 50_000),
                np.array(
                    text.replace(
                        f'"version": {FORMAT_VERSION}',
                        '"version": ' + draw.choice(("0", "1.0", "true", '"1"', "9" * 5000)),
                    )
                ),
                np.array(text.replace('"settings": {', '"settings": {"a": ' + "[" * 900 + "]" * 900 + ",")),
                np.array(text[: draw.randrange(len(text))]),
                np.array(text.encode()),
                np.array([text]),
                np.array({"format": "mjbiped walk"}, dtype=object),
                np.array(1.0),
            )
        )
    )
    return packed(members)


DAMAGES = (
    flip_bytes,
    flip_directory,
    cut_bytes,
    change_members,
    change_array_header,
    change_array,
    change_array,
    change_header,
    change_header,
    replace_header,
)


def damaged(records: list[bytes], case: int) -> bytes:
    draw = random.Random(case)
    return DAMAGES[case % len(DAMAGES)](draw, draw.choice(records))


# ---- what must hold --------------------------------------------------------------------------------------------------


def assert_refused_or_good(path: Path, *, drawn: bool, filmed: bool = False) -> bool:
    """Whether a file was loaded; then everything that takes a record must take this one."""
    try:
        walk = Walk.load(path)
    except RecordError as error:
        message = str(error)
    else:
        message = ""
    if message:
        assert str(path) in message
        assert len(message) < LONGEST_MESSAGE
        assert "memory" not in message
        return False
    with np.errstate(all="ignore"):
        summary = measures.summary(walk)
    assert summary["outcome"] == walk.outcome
    assert len(repr(walk)) < LONGEST_MESSAGE
    assert "\n" not in repr(walk)
    again = path.with_name("again.npz")
    walk.save(again)
    assert Walk.load(again) == walk
    if drawn:
        assert all(isinstance(text, str) for line in flattened(walk.settings) for text in line)
    if drawn and len(walk.samples["time"]):
        plot_walk(walk).draw_without_rendering()
    if drawn:
        with suppress(mjbiped.MjbipedError):  # a record without what it takes
            stability(walk)
    if filmed and len(walk.samples["time"]):
        times = (
            walk.samples["time"][0],
            walk.samples["time"][len(walk.samples["time"]) // 2],
            walk.samples["time"][-1],
        )
        render_frame(walk, times, width=64, height=64)
    return True


def try_cases(records: list[bytes], cases: range, folder: Path, *, draw_every: int, film_every: int = 0) -> int:
    path = folder / "walk.npz"
    loaded = 0
    for case in cases:
        path.write_bytes(damaged(records, case))
        try:
            with within(LONGEST, case):
                filmed = film_every > 0 and case % film_every == 0
                loaded += assert_refused_or_good(path, drawn=case % draw_every == 0, filmed=filmed)
        except Exception as error:
            raise AssertionError(f"case {case}, {DAMAGES[case % len(DAMAGES)].__name__}: {error!r}") from error
    return loaded


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::RuntimeWarning", "ignore:Glyph", "ignore:Reading `.npy`:UserWarning")
def test_damaged_records(records: list[bytes], tmp_path: Path) -> None:
    loaded = try_cases(records, range(FEW), tmp_path, draw_every=17)
    assert 0 < loaded < FEW / 2


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::RuntimeWarning", "ignore:Glyph", "ignore:Reading `.npy`:UserWarning")
@pytest.mark.parametrize("part", range(8))
def test_damaged_records_by_the_thousand(records: list[bytes], tmp_path: Path, part: int) -> None:
    each = MANY // 8
    film_every = 13 if gl_available() else 0
    cases = range(FEW + part * each, FEW + (part + 1) * each)
    try_cases(records, cases, tmp_path, draw_every=7, film_every=film_every)
