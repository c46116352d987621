"""The runner of the benchmarks, without the benchmarks themselves."""

from documentation import table

from scripts.benchmarks import __main__ as runner


def test_each_benchmark_has_its_table() -> None:
    for name, benchmark in runner.BENCHMARKS.items():
        assert [*table("performance", name)[0]] == [heading.replace("`", "") for heading in benchmark.headings]
