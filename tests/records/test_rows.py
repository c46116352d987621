from __future__ import annotations

from collections.abc import Callable, Mapping
from inspect import signature
from typing import Any

import numpy as np
import pytest

from mjbiped.records.columns import SAMPLES, TOUCHDOWNS, Column, split, tables_of
from mjbiped.records.rows import (
    KNEED_SAMPLED,
    SAMPLED,
    TOUCHED,
    rows_of,
    write_kneed_sample,
    write_sample,
    write_touchdown,
)
from mjbiped.robots.kinds import KINDS
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot


@pytest.mark.parametrize(
    ("write", "columns", "size"),
    [(write_sample, SAMPLES, SAMPLED), (write_touchdown, TOUCHDOWNS, TOUCHED)],
    ids=["samples", "touchdowns"],
)
def test_every_column_is_written_where_it_is_read(
    write: Callable[..., None], columns: Mapping[str, Column], size: int
) -> None:
    assert list(signature(write).parameters) == ["row", "first", *columns]
    numbers = iter(range(size))
    values = {name: tuple(float(next(numbers)) for _ in range(column.width)) for name, column in columns.items()}
    row = np.full(size, np.nan)
    write(row, 0, **{name: value if len(value) > 1 else value[0] for name, value in values.items()})
    assert {name: tuple(table.ravel()) for name, table in split(columns, row[None]).items()} == values


def test_what_an_engine_leaves_out_is_nan() -> None:
    columns = tables_of(KneedBiped).samples
    optional = [name for name, column in columns.items() if column.optional]
    row = np.zeros(KNEED_SAMPLED)
    given = {name: (1.0,) * column.width for name, column in columns.items() if name not in optional}
    write_kneed_sample(row, 0, **{name: value if len(value) > 1 else value[0] for name, value in given.items()})
    assert optional == ["stance_knee_torque"]
    assert np.isnan(row).tolist() == [False] * (KNEED_SAMPLED - 1) + [True]


@pytest.mark.parametrize("kind", KINDS.values())
def test_one_call_serves_every_robot(kind: type[Robot]) -> None:
    rows, columns = rows_of(kind), tables_of(kind).touchdowns
    every = [each for other in KINDS.values() for each in tables_of(other).touchdowns.items()]
    widest = dict(sorted(every, key=lambda each: each[1].width))
    given: dict[str, Any] = {}
    for place, (name, column) in enumerate(widest.items()):
        numbers = tuple(100.0 * place + k for k in range(column.width))
        given[name] = numbers if column.parts else numbers[0]
    row = np.full(rows.touched + 3, np.inf)
    rows.write_touchdown(row, 3, **given)
    for name, values in split(columns, row[3:][None]).items():
        np.testing.assert_array_equal(np.ravel(values), np.ravel(given[name])[: np.size(values)])
