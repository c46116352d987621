"""What the window says, in the characters that MuJoCo's font has: ASCII."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Collection

from mjbiped.errors import shortened
from mjbiped.records.signals import SIGNALS, torques_of
from mjbiped.rendering.moments import Moment
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.palette import IN_WORDS
from mjbiped.viewing.player import KEYS, MOUSE, Player

Columns = tuple[str, str]
"""Names and values, or keys and what they do; a line each."""

_SLOWER = 0.9  # of the speed that is asked for; what is reached below that is said
_CAPTION = 36  # characters of a terrain's name
_WIDTH = 60  # characters of a line of news


def state(player: Player, moment: Moment, elements: Collection[str]) -> Columns:
    """Time, speed, ground, and what the marks mean."""
    speed = f"{player.speed:.3g} x"
    if player.paused:
        speed += " (paused)"
    elif player.reached < _SLOWER * player.speed:
        speed += f" (reached {player.reached:.2g} x)"
    lines = [
        ("ground", ground(player.source.terrain)),
        ("time", f"{moment.time:.2f} s, step {moment.step}"),
        ("speed", speed),
        ("slope", f"{math.degrees(moment.slope):+.1f} deg"),
    ]
    if math.isfinite(moment.slope_estimate):
        mark = f" ({IN_WORDS[SIGNALS['slope_estimate'].colour]} line)" if "estimate" in elements else ""
        lines.append((f"slope estimate{mark}", f"{math.degrees(moment.slope_estimate):+.1f} deg"))
    if "torque" in elements:
        for signal, torque in zip(torques_of(type(player.source.robot)), moment.torque, strict=True):
            lines.append((f"{signal.name} torque ({IN_WORDS[signal.colour]} arc)", f"{torque:+.1f} N m"))
    if "force" in elements:
        lines.append(("ground force (black arrow)", f"{math.hypot(*moment.force):.0f} N"))
    names, values = zip(*lines, strict=True)
    return "\n".join(names), "\n".join(values)


def keys() -> Columns:
    """The help."""
    rows = [*((key.name, key.does) for key in KEYS.values()), *MOUSE.items()]
    return "\n".join(name for name, _ in rows), "\n".join(does for _, does in rows)


def news(player: Player) -> str:
    """How the walk ended, and what the last key led to."""
    source = player.source
    lines = [f"{source.ended} - Backspace begins anew"] if source.ended else []
    return "\n".join([*lines, *textwrap.wrap(source.news, _WIDTH)])


def ground(terrain: Terrain) -> str:
    """The terrain's name, in short."""
    seed = dict(terrain.parameters).get("seed")
    return plain(shortened(terrain.caption, _CAPTION) if seed is None else f"{terrain.name}, seed {seed}")


def plain(text: str) -> str:
    """A text in ASCII."""
    for sign, instead in (("−", "-"), ("–", "-"), ("°", " deg"), ("×", "x"), ("±", "+-"), (" ", " ")):
        text = text.replace(sign, instead)
    return text.encode("ascii", "replace").decode()
