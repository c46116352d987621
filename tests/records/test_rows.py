from __future__ import annotations

from collections.abc import Callable, Mapping
from inspect import signature

import numpy as np
import pytest

from mjbiped.records.columns import SAMPLES, TOUCHDOWNS, Column, split, tables_of
from mjbiped.records.rows import KNEED_SAMPLED, SAMPLED, TOUCHED, write_kneed_sample, write_sample, write_touchdown
from mjbiped.robots.kneed import KneedBiped


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
