"""The runner of the benchmarks, without the benchmarks themselves."""

from documentation import table

from scripts.benchmarks import __main__ as runner
from scripts.benchmarks.timing import interleaved


def test_each_benchmark_has_its_table() -> None:
    for name, benchmark in runner.BENCHMARKS.items():
        assert [*table("performance", name)[0]] == [heading.replace("`", "") for heading in benchmark.headings]


def test_cases_are_timed_in_turn_and_compared_in_pairs() -> None:
    order: list[str] = []

    def case(name: str, seconds: float) -> float:
        order.append(name)
        return seconds

    timings = interleaved({"a": (lambda: case("a", 1.0), 10), "b": (lambda: case("b", 4.0), 20)}, 2, "test")
    assert order == ["a", "b"] * 3  # the first round is not counted
    assert len(timings["a"].seconds) == 2
    assert timings["a"].ratio(timings["b"]) == "2 (2 to 2)"
