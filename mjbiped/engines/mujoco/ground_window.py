"""Long terrains: the model holds a window of the ground about the robot, so a step costs the same on any length.

MuJoCo takes in every geom at every step, some 10 ns each, and its compiler is slower than in proportion. So of a
terrain of more than `FEW_SEGMENTS` segments only those about the robot are built, and near the window's end the next
window's model takes over the state. The pieces of the ground are cut by the terrain alone
(`mjbiped.engines.mujoco.ground`) and stand in one coordinate system: every contact is bitwise that of the whole
terrain, whatever window it was found in.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from mjbiped.engines.mujoco.callback import python_removed
from mjbiped.engines.mujoco.ground import FEW_SEGMENTS, Ground, Piece
from mjbiped.engines.mujoco.scene import scene_spec
from mjbiped.engines.mujoco.scenery import add_section
from mjbiped.robots.robot import Robot
from mjbiped.utils.mujoco import mujoco

MARGIN = 2.0
"""Ground about the hip that is never missing, in leg lengths: a leg, and what a fall can go."""

_AHEAD = 20.0  # of the hip in a new window, in leg lengths, while these are few segments
_TURN = 1.0  # behind the margin, in leg lengths: who turns back and forth does not build at each turn
_LEAST = 3.0  # ahead of the margin, in leg lengths, of however many segments
_COARSE = 64
"""Pixels of a texture's edge in models that are stepped: viewers show them, too, and they are compiled in no time."""


@dataclass(frozen=True)
class Scene:
    """A compiled scene.

    Attributes:
        model: The MuJoCo model.
        pieces: Of the ground, those that were built.
        start: Where the ground begins, x in m.
        end: Where it ends, x in m: the terrain's own end, or as far as was built.
        inside: Between which places (m) it has all ground about the hip; infinite where nothing more can be built.
    """

    model: mujoco.MjModel
    pieces: list[Piece]
    start: float
    end: float
    inside: tuple[float, float]


@dataclass(frozen=True)
class GroundWindows:
    """Builds the scene about any place of a terrain.

    Attributes:
        robot: The robot.
        ground: The terrain, cut into pieces.
        timestep: Of the steps that the contacts are made for, s. Their damping is 1 / timestep: with it an impact is
            plastic within one step.
        margin: Ground about the hip that is never missing, m; `MARGIN` leg lengths or more.
        userdata: Number of floats in `mjData.userdata`.
        scenery: For pictures: the ground cut open, and fine textures, which take 5 MB and 12 ms.
    """

    robot: Robot
    ground: Ground
    timestep: float
    margin: float
    userdata: int = 0
    scenery: bool = False

    def pieces_about(self, x: float) -> list[Piece]:
        """The pieces to be built for a hip at x (m); all where their segments are few."""
        starts, length = self.ground.terrain.x, self.robot.leg_length
        if len(starts) <= FEW_SEGMENTS:
            return self.ground.pieces
        few = starts[min(self.ground.terrain.segment_at(x) + FEW_SEGMENTS, len(starts) - 1)]
        ahead = max(self.margin + _LEAST * length, min(self.margin + _AHEAD * length, few - x))
        return self.ground.between(x - self.margin - _TURN * length, x + ahead)

    def about(self, x: float) -> Scene:
        """Build the scene about a hip at x (m)."""
        ground, pieces = self.ground, self.pieces_about(x)
        with python_removed():
            spec = scene_spec(self.robot, ground, pieces, timestep=self.timestep)
            spec.nuserdata = self.userdata
            first, last = pieces[0].segments[0], pieces[-1].segments[-1]
            begins, ends = first == 0, last == len(ground.stops) - 1
            if self.scenery:
                add_section(spec, ground, pieces, self.robot.leg_length)
            else:
                for texture in spec.textures:
                    texture.width = texture.height = _COARSE
            model = spec.compile()
        start, end = ground.starts[first], ground.stops[last]
        inside = -math.inf if begins else start + self.margin, math.inf if ends else end - self.margin
        return Scene(model, pieces, start, end, inside)
