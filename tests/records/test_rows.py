from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mjbiped.records.columns import split, tables_of, width
from mjbiped.records.rows import rows_of
from mjbiped.robots.kinds import KINDS
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot


@pytest.mark.parametrize("table", ["samples", "touchdowns"])
@pytest.mark.parametrize("kind", KINDS.values())
def test_one_call_writes_the_columns_of_every_robot_where_they_are_read(kind: type[Robot], table: str) -> None:
    rows, columns = rows_of(kind), getattr(tables_of(kind), table)
    write, size = {
        "samples": (rows.write_sample, rows.sampled),
        "touchdowns": (rows.write_touchdown, rows.touched),
    }[table]
    assert size == width(columns)
    every = [each for other in KINDS.values() for each in getattr(tables_of(other), table).items()]
    widest = dict(sorted(every, key=lambda each: each[1].width))
    given: dict[str, Any] = {}
    for place, (name, column) in enumerate(widest.items()):
        numbers = tuple(100.0 * place + k for k in range(column.width))
        given[name] = numbers if column.width > 1 else numbers[0]
    row = np.full(size + 3, np.inf)
    write(row, 3, **given)
    assert np.isinf(row[:3]).all()
    for name, values in split(columns, row[3:][None]).items():
        np.testing.assert_array_equal(np.ravel(values), np.ravel(given[name])[: np.size(values)])


def test_what_an_engine_leaves_out_is_nan() -> None:
    columns, rows = tables_of(KneedBiped).samples, rows_of(KneedBiped)
    optional = [name for name, column in columns.items() if column.optional]
    row = np.zeros(rows.sampled)
    given = {name: (1.0,) * column.width for name, column in columns.items() if name not in optional}
    rows.write_sample(row, 0, **{name: value if len(value) > 1 else value[0] for name, value in given.items()})
    assert optional == ["stance_knee_torque"]
    assert np.isnan(row).tolist() == [False] * (rows.sampled - 1) + [True]
