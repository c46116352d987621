"""Named terrains: constructors that `mjbiped.Terrain` inherits."""

from __future__ import annotations

import math
from collections.abc import Callable
from inspect import signature
from typing import Annotated, Self

from mjbiped.errors import prefixed
from mjbiped.terrain.drawn import Changes, Drawn, Slope
from mjbiped.terrain.profile import Segment, check_slope
from mjbiped.terrain.surface import Stretch
from mjbiped.utils import domains
from mjbiped.utils.domains import checked, known_name

PRESETS = ("level", "incline", "slopes", "stairs", "mixed", "random", "treads", "waves", "bumps", "recorded")
"""Names of the terrains that a method of `Terrain` of that name makes; only "recorded" needs an argument, a file."""

RANDOM = ("random", "treads", "waves", "bumps", "recorded")
"""Names of the terrains that have a seed."""

_MIXED: tuple[Segment, ...] = (
    (2.0, 0.0, 0.0),
    (1.5, 1.5, 0.0),
    (1.8, 3.0, 0.0),
    (1.6, 1.0, -0.020),
    (2.4, 2.0, 0.008),
    (1.2, 0.0, -0.030),
    (1.7, -1.5, 0.0),
    (2.0, -3.0, 0.0),
    (1.4, -1.0, 0.0),
    (2.6, -2.0, -0.010),
    (1.5, 0.0, 0.005),
    (3.0, 1.5, -0.015),
    (1.3, -0.5, 0.0),
    (1.9, 0.5, 0.003),
)


class Presets(Drawn):
    """Constructors of named terrains, which `mjbiped.Terrain` inherits."""

    @classmethod
    @checked
    def level(cls, lateral_deg: Slope = 0.0) -> Self:
        """Make endless ground that is level ahead; `lateral_deg`: its slope across in degrees, positive to the left."""
        return cls._of_segments([(1.0, 0.0, 0.0)], "level", {"lateral_deg": lateral_deg})

    @classmethod
    @checked
    def incline(cls, slope_deg: Slope = 3.0, lateral_deg: Slope = 0.0) -> Self:
        """Make an endless slope: `slope_deg` in degrees, positive downhill, and `lateral_deg`, positive to the left."""
        given = {"slope_deg": slope_deg, "lateral_deg": lateral_deg}
        return cls._of_segments([(1.0, slope_deg, 0.0)], "incline", given)

    @classmethod
    @checked
    def stairs(
        cls,
        tread: Stretch = 1.8,
        rise: Annotated[float, domains.STEP] = -0.06,
        first: Annotated[float | None, domains.STRETCH] = None,
        count: Changes = 20,
        lateral_deg: Slope = 0.0,
    ) -> Self:
        """Make stairs of level treads (the paper's, in section V-A, have 1.8 m treads with steps of 0.006 and 0.06 m).

        The 20 risers of the default reach 35 m: more than 60 steps of 0.38 m.

        Args:
            tread: Depth of a tread, m, > 0.
            rise: Height of a step, m, positive up; at most `HIGHEST_STEP` either way.
            first: Distance from the start to the first riser, m, > 0; half a tread if left out.
            count: Number of risers, >= 1; the last tread goes on.
            lateral_deg: Slope of the treads across, degrees, positive down to the left.

        Raises:
            InputError: A value outside its domain.
        """
        first = domains.STRETCH.check("first", tread / 2.0) if first is None else first
        given = locals().copy()
        return cls._of_segments([(first, 0.0, 0.0), *[(tread, 0.0, rise)] * count], "stairs", given)

    @classmethod
    @checked
    def slopes(
        cls,
        length: Stretch = 1.5,
        change_deg: Annotated[float, domains.SLOPE_DEG] = 0.3,
        count: Changes = 16,
        start_deg: Slope = 0.0,
        lateral_deg: Slope = 0.0,
    ) -> Self:
        """Make ground whose slope changes by the same angle at equal distances (the paper's: 1.5 m, 0.3 and -1 degree).

        The 16 changes of the default reach 24 m: more than 60 steps of 0.38 m.

        Args:
            length: Length of a segment along the ground, m, > 0.
            change_deg: Change of the slope from one segment to the next, degrees, positive towards downhill.
            count: Number of changes, >= 1; the last segment goes on.
            start_deg: Slope of the first segment, degrees.
            lateral_deg: Slope of all segments across, degrees, positive down to the left.

        Raises:
            InputError: A value outside its domain, or a slope that gets too steep: ask for fewer or smaller changes.
        """
        given = locals().copy()
        check_slope(f"start_deg + {count} x change_deg", math.radians(start_deg + count * change_deg))
        rows = [(length, start_deg + k * change_deg, 0.0) for k in range(count + 1)]
        return cls._of_segments(rows, "slopes", given)

    @classmethod
    def mixed(cls) -> Self:
        """Make a fixed terrain of mixed slopes and steps, in the manner of the paper's Fig. 4.

        The paper's own table is in a figure and not in its text; this one is ours. Slope positive downhill, step
        positive up, "-" where two segments meet without one; the last segment goes on.

        | segment | length (m) | slope (deg) | step (m) |
        |---------|------------|-------------|----------|
        | 1       | 2.0        | 0.0         | -        |
        | 2       | 1.5        | 1.5         | -        |
        | 3       | 1.8        | 3.0         | -        |
        | 4       | 1.6        | 1.0         | -0.020   |
        | 5       | 2.4        | 2.0         | 0.008    |
        | 6       | 1.2        | 0.0         | -0.030   |
        | 7       | 1.7        | -1.5        | -        |
        | 8       | 2.0        | -3.0        | -        |
        | 9       | 1.4        | -1.0        | -        |
        | 10      | 2.6        | -2.0        | -0.010   |
        | 11      | 1.5        | 0.0         | 0.005    |
        | 12      | 3.0        | 1.5         | -0.015   |
        | 13      | 1.3        | -0.5        | -        |
        | 14      | 1.9        | 0.5         | 0.003    |

        It is 25.9 m long along the ground. Steps up stand only where the slope turns downhill or by no more than a
        degree: the passive gait's swing foot clears 9 mm at 10 cm ahead of the stance foot, 26 mm at 20 cm and at most
        46 mm.
        """
        return cls._of_segments(_MIXED, "mixed")

    @classmethod
    def preset(cls, name: str, **parameters: object) -> Self:
        """Make a terrain by its name in `PRESETS`, with the parameters of that constructor.

        Raises:
            InputError: An unknown name or parameter, with the valid ones listed, or a value outside its domain.
        """
        make: Callable[..., Self] = getattr(cls, known_name("terrain", name, PRESETS))
        for key in parameters:
            known_name(f"parameter of the terrain {name}", key, signature(make).parameters)
        with prefixed(f"terrain {name}: "):
            return make(**parameters)
