"""The runner of the benchmarks, without the benchmarks themselves."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from documentation import table

from scripts.benchmarks import __main__ as runner
from scripts.benchmarks.timing import Timing, interleaved


def test_each_benchmark_has_its_table() -> None:
    for name, benchmark in runner.BENCHMARKS.items():
        assert [*table("performance", name)[0]] == [heading.replace("`", "") for heading in benchmark.headings]


def test_a_benchmark_writes_its_table_and_nothing_else(tmp_path: Path) -> None:
    ran = CliRunner().invoke(runner.main, ["machine", "--tables", str(tmp_path)])
    assert ran.exit_code == 0, ran.output
    assert [file.name for file in tmp_path.iterdir()] == ["machine.csv"]
    firsts = [line.split(",")[0] for line in (tmp_path / "machine.csv").read_text(encoding="utf-8").splitlines()]
    assert firsts[:3] == ["machine", "processor", "system"]


def test_a_missing_package_leaves_the_table_and_the_next_is_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "gone.csv").write_text("old")
    gone = runner.Benchmark("something", ("a",), "no_such_module:rows")
    monkeypatch.setattr(runner, "BENCHMARKS", {"gone": gone, "machine": runner.BENCHMARKS["machine"]})
    ran = CliRunner().invoke(runner.main, ["--tables", str(tmp_path)])
    assert ran.exit_code == 0, ran.output
    assert "gone: the table stays as it is" in ran.output
    assert (tmp_path / "gone.csv").read_text() == "old"
    assert "processor" in (tmp_path / "machine.csv").read_text(encoding="utf-8")


def test_unknown_names_are_refused_with_the_valid_ones() -> None:
    ran = CliRunner().invoke(runner.main, ["starts"])
    assert ran.exit_code == 2
    assert "startup" in ran.output


def test_cases_are_timed_in_turn_and_compared_in_pairs() -> None:
    order: list[str] = []

    def case(name: str, seconds: float) -> float:
        order.append(name)
        return seconds

    timings = interleaved({"a": (lambda: case("a", 1.0), 10), "b": (lambda: case("b", 4.0), 20)}, 2, "test")
    assert order == ["a", "b"] * 3  # the first round is not counted
    assert len(timings["a"].seconds) == 2
    assert timings["a"].ratio(timings["b"]) == "2 (2 to 2)"


def test_a_timing_is_told_as_median_and_range() -> None:
    timing = Timing(np.array([1.0, 2.0, 4.0]), work=100)
    assert timing.rate == "50 (25 to 100)"
    assert timing.each(1e-3) == "20.00 (10.00 to 40.00)"
    assert timing.median(1e-3) == "20.0"
