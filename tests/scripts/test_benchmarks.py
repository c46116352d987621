"""The runner of the benchmarks, without the benchmarks themselves."""

import pytest

from scripts.benchmarks import __main__ as runner
from scripts.benchmarks.timing import interleaved


@pytest.mark.parametrize("name", runner.BENCHMARKS)
def test_each_benchmark_has_its_table_on_the_page(name: str) -> None:
    page = runner.PAGE.read_text(encoding="utf-8")
    table = page.partition(f"<!-- {name} -->\n")[2].partition(f"<!-- end {name} -->")[0].splitlines()
    assert table[0] == f"| {' | '.join(runner.BENCHMARKS[name].headings)} |"


def test_every_table_on_the_page_has_a_benchmark() -> None:
    page = runner.PAGE.read_text(encoding="utf-8").splitlines()
    marks = [line[len("<!-- end ") : -len(" -->")] for line in page if line.startswith("<!-- end ")]
    assert marks == list(runner.BENCHMARKS)


def test_cases_are_timed_in_turn_and_compared_in_pairs() -> None:
    order: list[str] = []

    def case(name: str, seconds: float) -> float:
        order.append(name)
        return seconds

    timings = interleaved({"a": (lambda: case("a", 1.0), 10), "b": (lambda: case("b", 4.0), 20)}, 2, "test")
    assert order == ["a", "b"] * 3  # the first round is not counted
    assert len(timings["a"].seconds) == 2
    assert timings["a"].ratio(timings["b"]) == "2 (2 to 2)"
