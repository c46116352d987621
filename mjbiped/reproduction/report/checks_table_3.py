"""What Table III and section V-D say of zeta, asked of our walks on one of the grounds that stand for the paper's."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

from mjbiped.reproduction.published import TABLE_3
from mjbiped.reproduction.report.answers import Answer, printed
from mjbiped.reproduction.report.markdown import NONE, delay, number
from mjbiped.reproduction.report.table_3 import walks_of
from mjbiped.reproduction.rows import Row

_ZETAS = [zeta for zeta in TABLE_3 if zeta is not None]
_LEAST = 0.8  # zeta of Table III's lowest c_mt
_REMARKABLE = (0.6, 0.7, 0.8, 0.9)  # V-D
_NEXT_TO_NONE = (0.4, 0.5)  # zeta between whose torques Table III's without re-planning lies


def answers(rows: Sequence[Row], ground: str, title: str, engine: str) -> Iterator[Answer]:
    """All claims about the table.

    Args:
        rows: Of the reproduction.
        ground: "mixed" or "found".
        title: Where that is, to begin a sentence with.
        engine: "hybrid" or "mujoco".
    """
    walks = walks_of(rows, ground, engine)
    lost = [f"ζ = {delay(zeta)}: {walk.outcome}" for zeta, walk in walks.items() if not walk.finished]
    claim = f"{title} the robot comes to the end with every ζ, and without re-planning"
    yield Answer(claim, "Table III", not lost if walks else None, "; ".join(lost) or f"{len(walks)} walks")
    ended = {zeta: walk for zeta, walk in walks.items() if walk.finished}
    yield _torque_falls(ended, title)
    yield _torque_without(ended, title)
    yield from _costs(ended, title)


def _survivors(zetas: Sequence[float]) -> str:
    """Which ζ a claim about all of them could be asked of, where not all."""
    if len(zetas) == len(_ZETAS):
        return ""
    return f"the {len(zetas)} of {len(_ZETAS)} ζ that came to their end"


def _torque_falls(ended: dict[float | None, Row], title: str) -> Answer:
    claim = f"{title} a smaller ζ takes a higher greatest torque"
    zetas = [zeta for zeta in _ZETAS if zeta in ended]
    if len(zetas) < 2:
        return Answer(claim, "V-D", None)
    torques = [ended[zeta].torque for zeta in zetas]
    found = f"{torques[0]:.5g} N m at ζ = {zetas[0]:g} to {torques[-1]:.5g} at {zetas[-1]:g}"
    return Answer(claim, "V-D", all(a > b for a, b in pairwise(torques)), found, _survivors(zetas))


def _torque_without(ended: dict[float | None, Row], title: str) -> Answer:
    high, low = _NEXT_TO_NONE
    claim = f"{title} the greatest torque without re-planning lies between those of ζ = {high:g} and {low:g}"
    found = ", ".join(
        f"{name} {number(ended[zeta].torque, '.4g') if zeta in ended else NONE}"
        for name, zeta in (("without", None), (f"ζ = {high:g}:", high), (f"ζ = {low:g}:", low))
    )
    if not {None, high, low} <= ended.keys():
        return Answer(claim, "Table III", None, f"{found} N m")
    holds = ended[low].torque < ended[None].torque < ended[high].torque
    return Answer(claim, "Table III", holds, f"{found} N m")


def _costs(ended: dict[float | None, Row], title: str) -> Iterator[Answer]:
    cost = {zeta: walk.cost["absolute", None] for zeta, walk in ended.items()}
    zetas = [zeta for zeta in _ZETAS if zeta in cost]
    of = _survivors(zetas)
    claim = f"{title} no ζ has a lower c_mt than {_LEAST:g}"
    if _LEAST in cost and len(zetas) > 1:
        least = min(zetas, key=lambda zeta: cost[zeta])
        found = f"{cost[_LEAST]:.4f}, lowest {cost[least]:.4f} at ζ = {least:g}"
        yield Answer(claim, "Table III", printed(cost[_LEAST]) <= printed(cost[least]), found, of)
    else:
        yield Answer(claim, "Table III", None)
    claim = f"{title} each ζ from {_REMARKABLE[0]:g} to {_REMARKABLE[-1]:g} has a lower c_mt than every other ζ"
    others = [zeta for zeta in zetas if zeta not in _REMARKABLE]
    if others and set(_REMARKABLE) <= cost.keys():
        high, low = max(_REMARKABLE, key=lambda zeta: cost[zeta]), min(others, key=lambda zeta: cost[zeta])
        found = f"at most {cost[high]:.4f} (ζ = {high:g}); the others at least {cost[low]:.4f} (ζ = {low:g})"
        yield Answer(claim, "V-D", printed(cost[high]) < printed(cost[low]), found, of)
    else:
        yield Answer(claim, "V-D", None)
    claim = f"{title} c_mt without re-planning is lower than with any ζ"
    if None in cost and zetas:
        low = min(zetas, key=lambda zeta: cost[zeta])
        found = f"{cost[None]:.4f}, lowest with it {cost[low]:.4f} at ζ = {low:g}"
        yield Answer(claim, "V-D", printed(cost[None]) < printed(cost[low]), found, of)
    else:
        yield Answer(claim, "V-D", None)
