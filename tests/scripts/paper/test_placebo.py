"""Placebos: what they find where the answer is known, and what the committed report's say."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from reproduction_rows import read_grounds

from mjbiped.studies.reproduction.claims import walks_of
from mjbiped.studies.reproduction.reproduce import GAINS_TABLE, GROUNDS_TABLE, TABLE
from mjbiped.studies.reproduction.results import Results, read_rows
from mjbiped.studies.reproduction.section_5 import GROUNDS, TABLE_2, TABLE_3
from mjbiped.studies.reproduction.tables import distance, turned
from scripts.paper import placebo
from scripts.paper.fits import SMALL_SHARE
from scripts.paper.gain_scan import Tried, fitted, read_tried
from scripts.paper.placebo import COUNT, ROWS, Placebo, RandomGround, drawn, write_grounds

DOCS = Path(__file__).parents[3] / "docs"


@pytest.fixture(scope="module")
def results() -> Results:
    return Results(read_rows((DOCS / TABLE).read_text(encoding="utf-8")))


@pytest.fixture(scope="module")
def tried() -> list[Tried]:
    return read_tried((DOCS / GAINS_TABLE).read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def grounds() -> list[RandomGround]:
    return read_grounds((DOCS / GROUNDS_TABLE).read_text(encoding="utf-8"))


def test_a_row_that_is_met_exactly_is_met_by_no_random_row() -> None:
    paper = np.log([0.034, 0.036])
    found = placebo.placebo(
        paper, np.stack([paper, paper + 1.0]), paper + np.array([[0.1, 0.1], [0.5, 0.5], [1.0, 0.9]])
    )
    assert (found.numbers, found.tried, found.distance, found.share) == (2, 2, 0.0, 0.0)
    # the nearest of both settings, by the root mean square: 0.1, 0.5 either way, and 0.1 of one number of two
    assert found.random == pytest.approx(0.1, rel=1e-12)


def test_a_number_that_no_setting_varies_is_not_drawn() -> None:
    """Otherwise hardly a random row is met, whatever the settings: the number that all give alike keeps it away."""
    generator = np.random.default_rng(5)
    settings, paper, rows = (generator.uniform(size=(count, 3)) for count in (50, 1, 400))
    settings[:, 1], paper[:, 1] = 0.5, 0.5004
    without = placebo.placebo(paper[0, ::2], settings[:, ::2], rows[:, ::2])
    found = placebo.placebo(paper[0], settings, rows)
    assert (found.numbers, found.varied, without.varied) == (3, 2, 2)
    assert found.share == without.share > 0.0


def test_a_row_among_its_like_is_met_as_near_as_half_of_them() -> None:
    """Of rows drawn as the random ones are, the share is uniform: a fit of nothing is no evidence."""
    generator = np.random.default_rng(5)
    settings = generator.uniform(size=(50, 3))
    shares = [
        placebo.placebo(generator.uniform(size=3), settings, generator.uniform(size=(400, 3))).share for _ in range(200)
    ]
    assert np.mean(shares) == pytest.approx(0.5, abs=4.0 / math.sqrt(12 * 200))  # four standard errors
    assert np.mean(np.array(shares) < SMALL_SHARE) == pytest.approx(SMALL_SHARE, abs=4.0 * math.sqrt(0.05 / 200))


def test_random_numbers_lie_between_the_printed_ones() -> None:
    mild = [value for row in TABLE_2.values() for ground, value in row.items() if value > 0.0 and ground != "stair 2"]
    for ground in GROUNDS:
        low, high = placebo.span(ground)
        assert math.log(high / low) == pytest.approx(math.log(max(mild) / min(mild)), rel=1e-12)
        for row in TABLE_2.values():
            value = row[ground]
            assert math.isnan(value) or low <= value <= high


def test_only_settings_with_the_paper_s_x_take_part(tried: list[Tried]) -> None:
    for method in fitted(tried):
        mine = [each for each in tried if each.variant.method == method]
        found = placebo.of_method(tried, method)
        crosses = {ground for ground, value in TABLE_2[method].items() if math.isnan(value)}
        in_kind = [each for each in mine if set(each.ended) == crosses]
        assert found.tried == len(in_kind)
        assert found.distance == pytest.approx(fitted(tried)[method].agreement.distance, rel=1e-9)


def test_the_reading_s_distance_is_the_choice_s(results: Results) -> None:
    found = placebo.of_readings(results)
    every = results.readings
    assert found.distance == pytest.approx(every[0].distance, rel=1e-9)
    assert found.tried == sum(math.isfinite(each.distance) for each in every)


def test_what_the_page_says_of_the_fits(results: Results, tried: list[Tried], grounds: list[RandomGround]) -> None:
    """No fit to Table II is evidence; KETC's comes nearest to it, and does not bear the error of the start."""
    shares = {method: placebo.of_method(tried, method).share for method in fitted(tried)}
    assert min(shares["PBC"], shares["ECC"], placebo.of_readings(results).share) > 0.5, (
        "most random rows are met as near"
    )
    assert SMALL_SHARE < shares["KETC"] < 0.2
    assert "KETC" in turned(results)
    assert "PBC" not in turned(results)
    of_table: Placebo = placebo.of_table_3(grounds)
    assert of_table.share == 0.0, "no random table is met as near"
    others = placebo.to_another(grounds)
    searched = distance(walks_of(results.rows, "found", "hybrid"))
    assert np.mean(others <= searched) > 0.5, "other grounds meet a ground's table nearer than the search the paper's"
    assert searched < of_table.distance, "but the search is nearer than the random grounds"


def test_random_tables_have_the_paper_s_order() -> None:
    """A ground whose table is in no order is nearer to none of them than one in order."""
    numbers = np.array([*TABLE_3.values()]).T
    ordered, reversed_ = (
        [RandomGround((), tuple(row[::sign]), tuple(cost[::sign])) for row, cost in [numbers] for _ in range(2)]
        for sign in (1, -1)
    )
    assert placebo.of_table_3(ordered).distance == 0.0
    assert placebo.of_table_3(ordered).random < placebo.of_table_3(reversed_).random


def test_grounds_are_of_the_family_and_the_same_again(grounds: list[RandomGround]) -> None:
    assert [each.segments for each in grounds] == drawn()
    assert len(grounds) == COUNT
    for each in grounds[::50]:
        flat = [value for k, row in enumerate(each.segments) for value in row[: 3 if k else 2]]
        assert all(low <= value <= high for value, (low, high) in zip(flat, placebo.bounds(), strict=True))
    assert write_grounds(grounds) == (DOCS / GROUNDS_TABLE).read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.usefixtures("studies_in_threads")
def test_committed_grounds_can_be_walked_again(grounds: list[RandomGround], tmp_path: Path) -> None:
    some = [next(each for each in grounds if each.torques), next(each for each in grounds if not each.torques)]
    found = placebo.walked([each.segments for each in some], tmp_path)
    # six digits are kept; the rest is for other processors' arithmetic
    assert found[0].torques == pytest.approx(some[0].torques, rel=2e-5)
    assert found[0].costs == pytest.approx(some[0].costs, rel=2e-5)
    assert found[1] == dataclasses.replace(some[1])


def test_random_rows_are_as_many_as_the_page_says() -> None:
    assert placebo._random([(1.0, 2.0), (1.0, 4.0)]).shape == (ROWS, 2)
