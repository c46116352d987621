"""Damaged policies: each is refused in one sentence, and nothing is allocated that a file only claims."""

from __future__ import annotations

import io
import os
import tracemalloc
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click
import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import ArrayLike

from mjbiped.errors import InputError
from scripts.learning import evaluate, export, train
from scripts.learning.checkpoint import Checkpoint

STORED = evaluate.STORED / "free-1.npz"


def changed(path: Path, **arrays: ArrayLike) -> None:
    """A stored policy with other arrays."""
    with np.load(STORED) as file, path.open("wb") as stream:
        np.savez(stream, **{**file, **arrays})


def claiming(path: Path) -> None:
    """A policy with a header that claims 745 GiB."""
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": "<f8", "fortran_order": False, "shape": (10**11,)})
    with zipfile.ZipFile(STORED) as stored, zipfile.ZipFile(path, "w") as archive:
        for name in stored.namelist():
            archive.writestr(name, stream.getvalue() if name == "returns.npy" else stored.read(name))


def one_array(path: Path) -> None:
    with path.open("wb") as stream:
        np.save(stream, np.zeros(3))


DAMAGED: dict[str, tuple[Callable[[Path], Any], str]] = {
    "one array": (one_array, "File is not a zip file"),
    "text": (lambda path: path.write_text("a policy"), "File is not a zip file"),
    "pipe": (os.mkfifo, "is a device or a pipe"),
    "claims": (claiming, "cannot reshape"),
    "seed of text": (lambda path: changed(path, seed="one"), "seed is of type <U3"),
    "seeds": (lambda path: changed(path, seed=[1, 2]), r"seed is of type int64 and shape \(2,\)"),
    "seed of none": (lambda path: changed(path, seed=np.nan), "seed is of type float64"),
    "kinds": (lambda path: changed(path, residual=[True, False]), "residual is of type bool"),
    "weights": (lambda path: changed(path, weights=np.full((2, 2, 8), np.nan)), "weights holds what is no finite"),
    "shape": (lambda path: changed(path, weights=np.zeros((2, 2, 7))), r"expected float64 and \(2, 2, 8\)"),
    "generations": (lambda path: changed(path, steps=np.zeros(3)), r"steps is of type float64 and shape \(3,\)"),
    "returns": (lambda path: changed(path, returns=np.array(3.0)), "expected generations, policies, grounds"),
}


@pytest.mark.parametrize("name", DAMAGED)
def test_a_damaged_policy_is_refused(name: str, tmp_path: Path) -> None:
    damage, message = DAMAGED[name]
    path = tmp_path / "free-1.npz"
    damage(path)
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match=message) as refused:
            Checkpoint.load(path)
        assert tracemalloc.get_traced_memory()[1] < 1 << 20
    finally:
        tracemalloc.stop()
    assert str(path) in str(refused.value)
    assert len(str(refused.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("program", "words"),
    [
        (train.main, ["--task", "free", "--generations", "60", "--out", "."]),
        (evaluate.main, ["--policies", "."]),
        (export.main, ["--policy", "free-1.npz", "--out", "policy.csv"]),
    ],
)
def test_the_programs_tell_it_in_a_line(
    program: click.Command, words: Sequence[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    one_array(tmp_path / "free-1.npz")
    said = CliRunner().invoke(program, words)
    assert (said.exit_code, said.output.count("\n")) == (2, 1), said.output
    assert said.output.startswith("Error: free-1.npz is no policy that scripts.learning.train wrote")


def test_a_policy_under_the_name_of_the_other_kind_is_refused(tmp_path: Path) -> None:
    changed(tmp_path / "residual-1.npz")
    with pytest.raises(InputError, match=r"residual-\*\.npz in .* of the other kind"):
        evaluate.trained(tmp_path)
