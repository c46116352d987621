"""Studies of a user's own controllers: workers load them, and rows belong to the file as it was."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import own_controllers
import pytest

import mjbiped
from mjbiped.control.loading import digest_of
from mjbiped.control.registry import make_controller
from mjbiped.errors import InputError, MjbipedError
from mjbiped.studies.plan import read_study
from mjbiped.studies.run import run

STUDY = """
engine = "hybrid"
steps = 2

[[controller]]
name = "laws/spread.py:HipSpread"
stiffness = [0.4, 0.5]

[[controller]]
name = "passive"

[terrain]
name = "incline"
slope_deg = 2
"""


@pytest.fixture
def study(tmp_path: Path) -> Iterator[Path]:
    """A study whose controller's file is looked for beside it, not in the working directory."""
    own_controllers.write(tmp_path, "laws/spread.py", own_controllers.SPREAD)
    path = [*sys.path]
    yield own_controllers.write(tmp_path, "study.toml", STUDY)
    sys.path[:] = path


@pytest.mark.slow
def test_workers_load_the_file(study: Path, tmp_path: Path, robot: mjbiped.Compass) -> None:
    """In processes of their own."""
    rows, *_ = run(read_study(study), tmp_path / "out", workers=1)
    assert [row["controller.name"] for row in rows] == ["laws/spread.py:HipSpread"] * 2 + ["passive"]
    assert [row["outcome"] for row in rows] == ["finished"] * 3
    law = make_controller(f"{tmp_path}/laws/spread.py:HipSpread", robot, {"stiffness": 0.4})
    alone = mjbiped.walk(law, mjbiped.Terrain.incline(2.0), engine="hybrid", steps=2, sample_period=1.0)
    assert rows[0]["cost_of_transport"] == alone.cost_of_transport, "as by itself, to the last bit"
    assert rows[0]["cost_of_transport"] != rows[1]["cost_of_transport"]


@pytest.mark.usefixtures("studies_in_threads")
def test_rows_belong_to_the_file_as_it_was(study: Path, tmp_path: Path) -> None:
    first, table, *_ = run(read_study(study), tmp_path / "out", workers=1)
    before = table.read_bytes()
    own_controllers.write(
        tmp_path, "laws/spread.py", own_controllers.SPREAD.replace("self.spread)", "self.spread) * 2")
    )
    edited = read_study(study)
    with pytest.raises(InputError, match=r"the source of the controller laws/spread\.py:HipSpread changed\. .*--fresh"):
        run(edited, tmp_path / "out", workers=1)
    assert table.read_bytes() == before
    again, *_ = run(edited, tmp_path / "out", workers=1, fresh=True)
    costs = [[row["cost_of_transport"] for row in rows] for rows in (first, again)]
    assert costs[0][:2] != costs[1][:2], "walked again, with the edited law"
    assert costs[0][2] == costs[1][2]


def test_a_file_that_changes_while_it_is_walked_is_refused(study: Path, tmp_path: Path) -> None:
    planned = read_study(study)
    laws = {name: digest_of(place) for name, place in planned.laws.items()}
    own_controllers.write(tmp_path, "laws/spread.py", own_controllers.SPREAD + "# changed\n")
    with pytest.raises(MjbipedError, match=r"source of the controller laws/spread\.py:HipSpread is another one"):
        planned.cells[0].row(laws=laws)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("spread.py", "gone.py", "'.*/laws/gone.py' .*there is no such file"),
        ("[0.4, 0.5]", '"stiff"', "stiffness = 'stiff': must be a finite number, as a field of HipSpread"),
        ('"laws/spread.py:HipSpread"', '["laws/spread.py:HipSpread", "adaptive"]', r"cell .*adaptive.*stiffness"),
    ],
)
def test_refused_before_anything_walks(old: str, new: str, words: str, study: Path) -> None:
    study.write_text(STUDY.replace(old, new))
    with pytest.raises(InputError, match=words):
        read_study(study)


def test_a_controller_that_fails_is_a_row_that_names_the_line(study: Path, tmp_path: Path) -> None:
    source = own_controllers.SPREAD.replace("        return", "        assert t < 0.3, 'too late'\n        return")
    own_controllers.write(tmp_path, "laws/spread.py", source)
    planned = read_study(study)
    row = planned.cells[0].row()
    assert row["outcome"] == "failed"
    assert "AssertionError: too late (spread.py, line 12, in torque: assert t < 0.3, 'too late')" in row["error"]
