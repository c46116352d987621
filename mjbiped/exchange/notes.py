"""What mjbiped's own engine does beyond an exported scene, in words for the file's comment."""

from __future__ import annotations

import textwrap
from pathlib import Path
from string import Template

from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.terrain import Terrain
from mjbiped.version import __version__

_WIDTH = 110  # characters of a line


def notes_of(robot: Robot, terrain: Terrain, timestep: float) -> str:
    """Describe an exported scene.

    Args:
        robot: The robot.
        terrain: The ground.
        timestep: Length of the file's steps, s.
    """
    behind, ahead = robot.sole or (0.0, 0.0)
    numbers = {"timestep": timestep, "behind": behind, "ahead": ahead, "reach": ScuffingRule().reach * robot.leg_length}
    words = {name: f"{number:g}" for name, number in numbers.items()}
    words |= {"kind": robot.kind, "terrain": terrain.caption, "version": __version__}
    left_out = {
        "scuffing" if robot.collides_from_lift_off else "lift_off",
        "" if "knee" in robot.joints else "knees",
        "" if robot.sole is not None else "sole",
    }
    text = Path(__file__).with_name("notes.txt").read_text(encoding="utf-8")
    notes = dict(line.split(": ", 1) for line in text.splitlines())
    lines = [Template(note).substitute(words) for name, note in notes.items() if name not in left_out]
    lines = ["".join(letter for letter in line if letter.isprintable()) for line in lines]  # XML holds no others
    told = "\n".join(textwrap.fill(line, _WIDTH, initial_indent="    ", subsequent_indent="    ") for line in lines)
    return f"\n{told.replace('--', '- -')}\n  "  # no comment in XML holds two hyphens
