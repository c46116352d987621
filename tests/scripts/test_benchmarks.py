"""The runner of the benchmarks, without the benchmarks themselves."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from scripts.benchmarks import __main__ as runner
from scripts.benchmarks.timing import Timing, interleaved


@pytest.mark.parametrize("name", runner.BENCHMARKS)
def test_each_benchmark_has_its_table_on_the_page(name: str) -> None:
    page = runner.PAGE.read_text(encoding="utf-8")
    table = page.partition(f"<!-- {name} -->\n")[2].partition(f"<!-- end {name} -->")[0].splitlines()
    assert table[0] == f"| {' | '.join(runner.BENCHMARKS[name].headings)} |"


def test_every_table_on_the_page_has_a_benchmark() -> None:
    page = runner.PAGE.read_text(encoding="utf-8").splitlines()
    marks = [line[len("<!-- end ") : -len(" -->")] for line in page if line.startswith("<!-- end ")]
    assert marks == list(runner.BENCHMARKS)


def test_a_benchmark_writes_its_table_and_nothing_else(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("before\n<!-- machine -->\n<!-- end machine -->\nbehind\n")
    ran = CliRunner().invoke(runner.main, ["machine", "--page", str(page)])
    assert ran.exit_code == 0, ran.output
    lines = page.read_text(encoding="utf-8").splitlines()
    assert lines[:2] == ["before", "<!-- machine -->"]
    assert lines[-2:] == ["<!-- end machine -->", "behind"]
    assert [line.split("|")[1].strip() for line in lines[4:8]] == [
        "processor",
        "system",
        "load in the last 1, 5, 15 minutes",
        "date",
    ]


def test_a_missing_package_leaves_the_table_and_the_next_is_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = tmp_path / "page.md"
    page.write_text("<!-- gone -->\nold\n<!-- end gone -->\n<!-- machine -->\n<!-- end machine -->\n")
    gone = runner.Benchmark("something", ("a",), "no_such_module:rows")
    monkeypatch.setattr(runner, "BENCHMARKS", {"gone": gone, "machine": runner.BENCHMARKS["machine"]})
    ran = CliRunner().invoke(runner.main, ["--page", str(page)])
    assert ran.exit_code == 0, ran.output
    assert "gone: the table stays as it is" in ran.output
    assert "old" in page.read_text(encoding="utf-8")
    assert "processor" in page.read_text(encoding="utf-8")


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
