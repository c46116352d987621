"""Claims of section V, tested on our walks by engine, and counted by what was fitted to the paper's numbers.

About Table II they are tested by a reading of its grounds; about Table III and Figs. 4 to 6 on two grounds of our own.
"""

from __future__ import annotations

import itertools
import math
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from operator import lt
from typing import NamedTuple

from mjbiped.control.registry import settings_of
from mjbiped.studies.reproduction import section_5 as paper
from mjbiped.studies.reproduction.cell import RESOLVED_SLOPE
from mjbiped.studies.reproduction.results import ENGINES, NO_WALK, NONE, Choice, Results, Row, find, in_words, select

CLAIMS: dict[str, dict[str, str]] = tomllib.loads((paper.FILES / "claims.toml").read_text(encoding="utf-8"))
"""The claims by name, as `claims.toml` describes them."""

GROUPS = UNFITTED, BLIND, FITTED, FOUND = "unfitted", "blind", "fitted", "found"
"""What is fitted to the paper's numbers in the walks that are tested: nothing; the reading of the grounds; the other
methods' settings as well; the ground."""

ZERO = 0.01
"""Greatest ratio of z2 with to without re-planning that counts as reduced to zero; our own bound."""

COUNTING = (UNFITTED, BLIND)
"""The groups that count as evidence: nothing but the reading of the grounds was fitted to their numbers."""

_HALF = 0.5 * 10.0**-paper.DIGITS
_PASSIVE = round(math.sin(paper.IMITATED_SLOPE), paper.DIGITS)
_LEAST = "0.8"  # zeta of Table III's lowest c_mt
_REMARKABLE = ("0.6", "0.7", "0.8", "0.9")  # V-D
_EPSILON = math.degrees(RESOLVED_SLOPE)
_ON_CYCLE = math.degrees(settings_of("adaptive")["replanning_threshold"])


class Answer(NamedTuple):
    """The answer of one engine's walks to a claim of the paper.

    Attributes:
        claim: The claim, a sentence that is true or false by itself.
        source: Place of the claim in the paper.
        holds: Whether the claim holds; None where its walks do not exist.
        found: Our numbers.
        of: The part of the walks that was tested, where others did not come to their end; else empty.
        engine: Engine of the walks.
        group: One of `GROUPS`.
    """

    claim: str
    source: str
    holds: bool | None
    found: str = ""
    of: str = ""
    engine: str = ""
    group: str = ""

    @property
    def verdict(self) -> str:
        """The answer in words, with the numbers; a dash without an answer."""
        if self.holds is None:
            return NONE
        said = ("holds" if self.holds else "**does not hold**") + (f" for {self.of}" if self.of else "")
        return f"{said}: {self.found}" if self.found else said


def checks(results: Results) -> list[Answer]:
    """Answer all claims, engine by engine and group by group."""
    return [
        each._replace(engine=engine, group=group)
        for engine in ENGINES
        for group, answers in (
            (UNFITTED, _of_adaptive(results, engine)),
            (BLIND, _of_all_methods(results, engine, "blind")),
            (FITTED, _of_all_methods(results, engine, "fitted")),
            (UNFITTED, _of_figures(results.rows, "mixed", "On our mixed ground", engine)),
            (FOUND, _of_figures(results.rows, "found", "On the ground that was found", engine)),
        )
        for each in answers
    ]


def walks_of(rows: Iterable[Row], ground: str, engine: str) -> dict[float | None, Row]:
    """Find the walks of Table III on one of the grounds, by zeta; None: no re-planning."""
    return {row.delay: row for row in select(rows, part="table 3", ground=ground, engine=engine)}


def _answer(name: str, holds: bool | None, of: str = "", **words: object) -> Answer:
    """Answer a claim, unless one of its numbers does not exist; words are filled into the claim's braces."""
    claim, found = (CLAIMS[name][text].format(**words) for text in ("claim", "found"))
    asked = holds is not None and "nan" not in found
    return Answer(claim, CLAIMS[name]["source"], *((holds, found, of) if asked else (None,)))


def _of_adaptive(results: Results, engine: str) -> Iterator[Answer]:
    """Test claims about the adaptive controller on level ground, where reading and zeta make no difference."""
    value = results.best.cost(results.walks("adaptive", engine=engine)[0])
    yield _level_number(value, "adaptive")
    off = abs(paper.TABLE_2["adaptive"]["level"] - _PASSIVE)
    yield _answer("level_passive", abs(round(value, paper.DIGITS) - _PASSIVE) < off + _HALF, value=value, off=off)


def _of_all_methods(results: Results, engine: str, settings: str) -> Iterator[Answer]:
    """Test claims about all methods; reading and zeta were fitted to the table's numbers.

    Args:
        results: The reproduction.
        engine: "hybrid" or "mujoco".
        settings: The other methods' settings, "blind" or "fitted".
    """
    best, of_method = results.best, {method: results.walks(method, settings, engine) for method in paper.TABLE_2}
    walks = {ground: {name: of_method[name][k] for name in of_method} for k, ground in enumerate(paper.GROUNDS)}
    cost = {ground: {method: best.cost(walk) for method, walk in walks[ground].items()} for ground in walks}
    shown = {ground: {method: round(value, paper.DIGITS) for method, value in cost[ground].items()} for ground in cost}
    say, level, stair = partial(_answer, cost=cost), shown["level"], shown["stair 1"]

    def similar(ground: str) -> Answer:
        """Test V-A's "similar energy efficiency on uneven terrains": as similar as the table's own numbers."""
        papers, ours = [paper.TABLE_2[method][ground] for method in paper.TABLE_2], shown[ground].values()
        allowed, spread = round(max(papers) - min(papers), paper.DIGITS), max(ours) - min(ours)
        return say(
            "similar", spread < allowed + _HALF, ground=ground, allowed=allowed, spread=spread, here=cost[ground]
        )

    for method in paper.ENERGY_BASED:
        yield _level_number(cost["level"][method], method)
    for method in ("PBC", "ECC"):
        nearer = abs(level["adaptive"] - _PASSIVE) < abs(level[method] - _PASSIVE) - _HALF
        yield say("closer_to_passive", nearer, method=method, other=cost["level"][method])
    yield say("same_as_ketc", level["adaptive"] == level["KETC"])
    yield say("higher_than_level", all(stair[method] - level[method] > _HALF for method in paper.TABLE_2))
    yield say("lowest", stair["adaptive"] < min(stair[method] for method in paper.ENERGY_BASED))
    yield similar("stair 1")
    yield say("lower_than_level", all(level[method] - shown["slope 1"][method] > _HALF for method in paper.TABLE_2))
    yield similar("slope 1")
    for ground in ("stair 2", "slope 2"):
        for method, walk in walks[ground].items():
            yield _comes_through(walk, best, method, ground)
    yield say("higher_than_adaptive", shown["slope 2"]["ECC"] > shown["slope 2"]["adaptive"])


def _name(method: str) -> str:
    return "the adaptive controller" if method == "adaptive" else method


def _level_number(value: float, method: str) -> Answer:
    """Compare a number of level ground, to half a unit of its last digit."""
    printed = paper.TABLE_2[method]["level"]
    return _answer("level_number", paper.meets(value, printed), method=_name(method), paper=printed, value=value)


def _comes_through(walk: Row, best: Choice, method: str, ground: str) -> Answer:
    """Test whether a method makes the steps over which the reading takes c_mt, or fails to, as in the table."""
    crossed, walked = math.isnan(paper.TABLE_2[method][ground]), math.isfinite(best.cost(walk))
    ended = f"c_mt {best.written(walk)}" if walked else f"{walk.outcome} after {walk.steps} steps"
    name, holds = "not_walked" if crossed else "walked", walked != crossed if walk.outcome else None
    return _answer(name, holds, ground=ground.capitalize(), method=_name(method), ended=ended)


def _of_figures(rows: Sequence[Row], ground: str, title: str, engine: str) -> Iterator[Answer]:
    """Test the claims about a ground that stands for the one of Table III and Figs. 4 to 6.

    Args:
        rows: Rows of the reproduction.
        ground: "mixed" or "found".
        title: Name of the ground, to begin a sentence with.
        engine: "hybrid" or "mujoco".
    """
    walks = walks_of(rows, ground, engine)
    starts = " and ".join(f"{start:+g}°" for start in paper.START_ESTIMATES).replace("-", "−")
    start = starts if ground == "mixed" else "0°"
    say = partial(_answer, on=title, start=start, epsilon=_EPSILON, on_cycle=_ON_CYCLE, zero=100 * ZERO)
    yield from _table_3(walks, say)
    if ground == "mixed":
        yield from _figure_4(_walks_of_figure_5(rows, engine, paper.PAPER_GAIN, "yes"), say)
        yield from _figure_5(rows, engine, say)
    else:
        yield from _figure_4([walks.get(paper.DRAWN_DELAYS[1], NO_WALK)], say)
    for name, most in (("travel", 1.0), ("error", 1.0), ("z2", ZERO)):  # V-D, Fig. 6
        a, b, without = (_values([walks.get(zeta, NO_WALK)], f"trace_{name}")[0] for zeta in paper.DRAWN_DELAYS)
        yield say(name, max(a, b) < most * without, a=a, b=b, without=without)


def _table_3(walks: Mapping[float | None, Row], say: Callable[..., Answer]) -> Iterator[Answer]:
    """Test the claims of Table III and section V-D on the walks of a ground by zeta; None: no re-planning."""
    lost = [f"ζ = {in_words(zeta)}: {walk.outcome}" for zeta, walk in walks.items() if not walk.finished]
    yield say("ends", not lost if walks else None, ended="; ".join(lost) or f"{len(walks)} walks")
    ended = {in_words(z): walk if (walk := walks.get(z, NO_WALK)).finished else NO_WALK for z in paper.TABLE_3}
    torque = {zeta: walk.torque for zeta, walk in ended.items()}
    cost = {zeta: float(walk.absolute_end) for zeta, walk in ended.items()}
    shown = {zeta: round(value, paper.DIGITS) for zeta, value in cost.items()}
    zetas = [zeta for zeta, walk in ended.items() if walk.finished and zeta != "none"]
    several, all_of_them = len(zetas) > 1, len(paper.TABLE_3) - 1
    of = "" if len(zetas) == all_of_them else f"the {len(zetas)} of {all_of_them} ζ that came to their end"
    ends = zetas[:1] + zetas[-1:] or [_LEAST] * 2
    falls = all(torque[a] > torque[b] for a, b in itertools.pairwise(zetas))
    yield say("falling_torque", falls if several else None, of, zetas=ends, torques=[torque[zeta] for zeta in ends])
    yield say("torque_between", torque["0.5"] < torque["none"] < torque["0.4"], torque=torque)
    least = min(zetas, key=cost.__getitem__, default=_LEAST)
    others = [zeta for zeta in zetas if zeta not in _REMARKABLE]
    high, low = max(_REMARKABLE, key=cost.__getitem__), min(others, key=cost.__getitem__, default=_LEAST)
    remarkable = shown[high] < shown[low] if {*_REMARKABLE} < {*zetas} else None
    words = {"cost": cost, "least": least, "lowest": cost[least], "high": high, "low": low}
    yield say("least_cost", shown[_LEAST] <= shown[least] if several else None, of, **words)
    yield say("remarkable", remarkable, of, most=cost[high], others=cost[low], **words)
    yield say("cheaper_without", shown["none"] < shown[least], of, **words)


def _walks_of_figure_5(rows: Sequence[Row], engine: str, gain: float, update: str) -> list[Row]:
    """Walks with one gamma, with or without the update (27), by `START_ESTIMATES`."""
    mine = {"part": "figure 5", "engine": engine, "adaptation_gain": gain, "update": update}
    return [find(rows, start_estimate=start, **mine) for start in paper.START_ESTIMATES]


def _figure_4(walks: Sequence[Row], say: Callable[..., Answer]) -> Iterator[Answer]:
    """Test the claims of section V-B, Fig. 4(b) to (d)."""
    yield _below(say, "settled", walks, "trace_settled", _EPSILON)
    yield _below(say, "later", walks, "trace_later", _EPSILON)
    straight, bent = max(_values(walks, "trace_straight")), min(_values(walks, "trace_bent"))
    yield say("straight", straight < bent, straight=straight, bent=bent)
    yield _below(say, "z1", walks, "trace_z1", _ON_CYCLE)


def _figure_5(rows: Sequence[Row], engine: str, say: Callable[..., Answer]) -> Iterator[Answer]:
    """Test the claims of section V-C about the estimate update."""
    with_it, without = (_walks_of_figure_5(rows, engine, paper.PAPER_GAIN, update) for update in ("yes", "no"))

    def less(name: str, column: str) -> Answer:
        """Test whether a number is smaller with the update than without, from every start."""
        a, b = _values(with_it, column), _values(without, column)
        return say(name, all(map(lt, a, b)), a=a, b=b)

    yield less("off_time", "trace_off_time")
    yield _below(say, "ended", without, "ended", _EPSILON)
    yield less("begun", "begun")
    slow = _walks_of_figure_5(rows, engine, min(paper.ADAPTATION_GAINS), "yes")
    yield _below(say, "jump", slow, "jump", _EPSILON, most=max(_values(slow, "begun")))


def _below(
    say: Callable[..., Answer], name: str, walks: Sequence[Row], column: str, bound: float, **words: float
) -> Answer:
    """Answer the claim that an angle is below a bound in some walks, degrees."""
    value = max(_values(walks, column))
    return say(name, value < bound, value=value, **words)


def _values(walks: Sequence[Row], column: str) -> list[float]:
    """A number of some walks; NaN throughout unless all walks have it and came to their end."""
    values = [float(getattr(walk, column)) if walk.finished else math.nan for walk in walks]
    return [math.nan] * len(values) if any(map(math.isnan, values)) else values


def by_claim(answers: Iterable[Answer], groups: Sequence[str] = GROUPS) -> dict[tuple[str, str, str], list[Answer]]:
    """Gather the engines' answers by group, claim and source: a claim counts once, in however many engines.

    Args:
        answers: Any number of answers.
        groups: The groups that are wanted.
    """
    found: dict[tuple[str, str, str], list[Answer]] = {}
    for each in answers:
        if each.group in groups:
            found.setdefault((each.group, each.claim, each.source), []).append(each)
    return found


def missed(answers: Iterable[Answer], *groups: str) -> str:
    """Count the claims of some groups that an engine denies, out of those that have an answer."""
    known = [{each.holds for each in said} - {None} for said in by_claim(answers, groups).values()]
    return f"{sum(False in said for said in known)} of {sum(map(bool, known))}"


def what_counts(answers: Iterable[Answer]) -> str:
    """Say which rows count, and how many of their claims do not hold."""
    return (
        f'What counts are the rows "{UNFITTED}" and "{BLIND}", whose settings were not chosen by the paper\'s numbers: '
        f"{missed(answers, *COUNTING)} claims do not hold in every engine that walked them. "
        f'In the rows "{FITTED}" the gains, in "{FOUND}" the ground were searched for so that they agree.'
    )
