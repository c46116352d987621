"""The ground: a piecewise-linear profile with vertical steps, in the plane x forward, z up.

Slope > 0 goes down in the walking direction (dz/dx = -tan slope), step > 0 goes up: the signs of the paper's Fig. 4.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from inspect import signature
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from mjbiped.errors import InputError, shortened, shown
from mjbiped.terrain.files import FILE_SUFFIXES, parse_parameters, read_samples, read_segments
from mjbiped.terrain.profile import Profile, height_of
from mjbiped.utils import domains
from mjbiped.utils.domains import Domain, check_interval, known_name

GROUND_FRICTION = 0.8
"""Coefficient of Coulomb friction of all walking ground."""

STEEPEST_SLOPE = math.atan(GROUND_FRICTION)
"""A slope of this angle (rad) or more cannot be stood on."""

HIGHEST_STEP = domains.STEP.high
"""Greatest height of a vertical step, up or down (m): half a leg of Table I."""

STEP_RESOLUTION = 1e-9
"""Height differences at a break of no more than this (m) are rounding, not steps; `domains.PLACE` keeps it so."""

MOST_SEGMENTS = domains.SEGMENTS.high
"""Greatest number of segments of one terrain."""

_RISE = Domain(-HIGHEST_STEP - STEP_RESOLUTION, HIGHEST_STEP + STEP_RESOLUTION, "m")  # a difference of rounded heights
_DEEPEST = 8  # tuples in tuples, of a parameter

_MIXED: tuple[tuple[float, float, float], ...] = (
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


@dataclass(frozen=True)
class Terrain:
    """A ground profile of straight segments, with vertical steps between them.

    Segment i covers x[i] <= x < x[i + 1]: at a break the segment that starts there counts (right-continuous). The first
    segment also extends backwards without limit, and the last one forwards.

    The start: the robot's stance foot stands at (0, height(0)) and its ground is the slope under x = 0; where a break
    or a step lies exactly at 0, that is the segment that starts there. The other foot, at rest or in a gait's first
    step, starts behind it on the ground as it is there.
    The end: ground is known up to `end`. `height` and `slope` continue the last segment beyond it, but a foot that is
    put down there has left the terrain, and the engines end the walk with that outcome. Only sampled profiles end; all
    other terrains go on for ever.

    Two terrains are equal, and have one hash, if all fields are equal bit by bit, name and parameters included.

    Attributes:
        x: Starts of the segments, ascending, m, shape (n,); x[0] <= 0.
        z: Heights at the starts of the segments, after the step there, m, shape (n,).
        angle: Slope angles of the segments, rad, shape (n,); positive goes down in the walking direction.
        end: The x up to which the ground is known, m; infinity for ground that goes on.
        name: What it is called in records and captions.
        parameters: Pairs (name, value) it was made with, for records and captions; nested tuples of plain values.

    Raises:
        InputError: Any value outside its domain: not finite, starts that do not ascend, a slope as steep as
            `STEEPEST_SLOPE`, a step higher than `HIGHEST_STEP`, x = 0 not on the ground.
    """

    x: tuple[float, ...]
    z: tuple[float, ...]
    angle: tuple[float, ...]
    end: float = math.inf
    name: str = "custom"
    parameters: tuple[tuple[str, Any], ...] = ()

    def __post_init__(self) -> None:
        """Bring the fields into plain tuples and check them."""
        for field, domain in (("x", domains.PLACE), ("z", domains.PLACE), ("angle", domains.ANGLE)):
            values = _listed(field, getattr(self, field))
            if len(values) > MOST_SEGMENTS:
                raise InputError(
                    f"the terrain has {len(values)} segments; at most {MOST_SEGMENTS} can be walked, make them longer"
                )
            checked = tuple(domain.check(f"segment {i}: {field}", value) for i, value in enumerate(values, start=1))
            object.__setattr__(self, field, checked)
        n = len(self.x)
        if not n or len(self.z) != n or len(self.angle) != n:
            raise InputError(
                f"a terrain needs as many starts x as heights z and angles, at least one; "
                f"got {n}, {len(self.z)} and {len(self.angle)}"
            )
        endless = isinstance(self.end, float) and self.end == math.inf
        object.__setattr__(self, "end", math.inf if endless else domains.PLACE.check("end", self.end))
        for i, (here, there) in enumerate(pairwise((*self.x, self.end)), start=1):
            if not here < there:
                raise InputError(
                    f"segment {i} starts at x = {here:.17g} m and stops at {there:.17g} m; each must have a length > 0"
                )
        if not self.x[0] <= 0.0 < self.end:
            raise InputError(
                f"the ground reaches from x = {self.x[0]:g} m to {self.end:g} m, but the robot starts at x = 0"
            )
        for i, angle in enumerate(self.angle, start=1):
            _check_slope(f"segment {i}", angle)
        for i, rise in enumerate(self.rises, start=1):
            _RISE.check(f"segment {i}: its step", rise)
        if not isinstance(self.name, str):
            raise InputError(f"name = {shown(self.name)}: must be text")
        object.__setattr__(self, "parameters", _frozen_pairs(self.parameters))

    def __repr__(self) -> str:
        """One line; the profile can be long, and `to_dict` has it."""
        count = f"{len(self.x)} segment{'' if len(self.x) == 1 else 's'}"
        reach = f"up to x = {self.end:g} m" if math.isfinite(self.end) else "without end"
        return f"<Terrain {self.caption}: {count} {reach}>"

    # ---- making one ----------------------------------------------------------------------------------------------

    @classmethod
    def from_segments(cls, segments: Iterable[Sequence[float]], name: str = "segments") -> Terrain:
        """Make a terrain of segments given one after another, the first from x = 0.

        Args:
            segments: One (length, slope, step) or (length, slope) per segment: the length along the ground in m, > 0;
                the slope in degrees, positive downwards; the step up in m at the segment's start, 0 if left out. The
                first segment has no riser, since it extends backwards: its step is the height at x = 0. The last one
                goes on beyond its length.
            name: What the terrain is called.

        Raises:
            InputError: No segments, or a value outside its domain; the message names the segment, counted from 1.
        """
        rows = _checked_segments(segments)
        return _chained(rows, name, (("segments", rows),))

    @classmethod
    def level(cls) -> Terrain:
        """Make level ground without end."""
        return cls((0.0,), (0.0,), (0.0,), name="level")

    @classmethod
    def incline(cls, slope_deg: float = 3.0) -> Terrain:
        """Make one constant slope without end; `slope_deg` in degrees, positive downwards."""
        slope = _checked_slope("slope_deg", slope_deg)
        return _chained([(1.0, slope, 0.0)], "incline", (("slope_deg", slope),))

    @classmethod
    def stairs(cls, tread: float = 1.8, rise: float = -0.06, first: float | None = None, count: int = 20) -> Terrain:
        """Make stairs of level treads (the paper's, in section V-A, have 1.8 m treads with steps of 0.006 and 0.06 m).

        The 20 risers of the default reach 35 m: more than 60 steps of 0.38 m.

        Args:
            tread: Depth of a tread, m, > 0.
            rise: Height of a step, m, positive up; at most `HIGHEST_STEP` either way.
            first: Distance from the start to the first riser, m, > 0; half a tread if left out.
            count: Number of risers, >= 1; the last tread goes on.

        Raises:
            InputError: A value outside its domain.
        """
        tread = domains.STRETCH.check("tread", tread)
        rise = domains.STEP.check("rise", rise)
        first = tread / 2.0 if first is None else domains.STRETCH.check("first", first)
        count = domains.CHANGES.check("count", count)
        rows = [(first, 0.0, 0.0)] + [(tread, 0.0, rise)] * count
        return _chained(rows, "stairs", (("tread", tread), ("rise", rise), ("first", first), ("count", count)))

    @classmethod
    def slopes(cls, length: float = 1.5, change_deg: float = 0.3, count: int = 16, start_deg: float = 0.0) -> Terrain:
        """Make ground whose slope changes by the same angle again and again (the paper's: 1.5 m, 0.3 and -1 degree).

        The 16 changes of the default reach 24 m: more than 60 steps of 0.38 m.

        Args:
            length: Length of a segment along the ground, m, > 0.
            change_deg: Change of the slope from one segment to the next, degrees, positive towards downhill.
            count: Number of changes, >= 1; the last segment goes on.
            start_deg: Slope of the first segment, degrees.

        Raises:
            InputError: A value outside its domain, or a slope that gets too steep: ask for fewer or smaller changes.
        """
        length = domains.STRETCH.check("length", length)
        change = domains.SLOPE_DEG.check("change_deg", change_deg)
        count = domains.CHANGES.check("count", count)
        start = _checked_slope("start_deg", start_deg)
        _check_slope(f"start_deg + {count} x change_deg", math.radians(start + count * change))
        rows = [(length, start + k * change, 0.0) for k in range(count + 1)]
        parameters = (("length", length), ("change_deg", change), ("count", count), ("start_deg", start))
        return _chained(rows, "slopes", parameters)

    @classmethod
    def mixed(cls) -> Terrain:
        """Make the house's mixed terrain of slopes and steps, in the manner of the paper's Fig. 4.

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
        return _chained(_MIXED, "mixed", ())

    @classmethod
    def random(
        cls,
        seed: int = 0,
        length: float = 25.0,
        segment_length: tuple[float, float] = (0.8, 2.0),
        slope_deg: tuple[float, float] = (-3.0, 3.0),
        rise: tuple[float, float] = (-0.02, 0.005),
        step_probability: float = 0.5,
        roughness: float = 0.0,
        spacing: float = 0.25,
    ) -> Terrain:
        """Make random ground; the same arguments give the same terrain bit by bit (NumPy's PCG64).

        The first metre is level and smooth, so that the start is defined; then come segments of uniformly drawn length,
        slope and step until `length` is reached; the last one goes on. `roughness` is added to this afterwards, and a
        seed draws the same segments with and without it.

        Args:
            seed: Seed of the generator, >= 0.
            length: Length of the ground along itself, m, >= 1.
            segment_length: Range of the segments' lengths, m, > 0.
            slope_deg: Range of the slopes, degrees.
            rise: Range of the steps, m, positive up.
            step_probability: How probable a step is at a segment's start, 0 to 1.
            roughness: Standard deviation of normally distributed heights of mean zero, m, >= 0, added about every
                `spacing` and at the breaks, linear in between, after the first metre and before the last segment's end.
            spacing: Distance between these heights, m, > 0; every segment is cut into equal cells nearest to it.

        Raises:
            InputError: A value outside its domain, or a slope too steep to be stood on: less roughness or a wider
                spacing keeps slopes gentle.
        """
        seed = domains.SEED.check("seed", seed)
        length = domains.RANDOM_STRETCH.check("length", length)
        lengths = check_interval("segment_length", segment_length, domains.STRETCH)
        slopes = check_interval("slope_deg", slope_deg, domains.SLOPE_DEG)
        for slope in slopes:
            _checked_slope("slope_deg", slope)
        rises = check_interval("rise", rise, domains.STEP)
        probability = domains.PROBABILITY.check("step_probability", step_probability)
        roughness = domains.ROUGHNESS.check("roughness", roughness)
        spacing = domains.STRETCH.check("spacing", spacing)
        finest = min(lengths[0], spacing) if roughness else lengths[0]
        if (length + lengths[1]) / finest > MOST_SEGMENTS:
            raise InputError(
                f"{length + lengths[1]:g} m in pieces of {finest:g} m can be more than {MOST_SEGMENTS} segments; "
                "take a shorter length, segments of longer least and shorter greatest length, or a wider spacing"
            )
        draw = np.random.Generator(np.random.PCG64(seed))
        rows, done = [(1.0, 0.0, 0.0)], 1.0
        while done < length:
            piece, slope, step = (float(draw.uniform(*ends)) for ends in (lengths, slopes, rises))
            rows.append((piece, slope, step if draw.random() < probability else 0.0))
            done += piece
        if roughness:
            rows = _roughened(rows, spacing, lambda: float(draw.normal(0.0, roughness)))
        parameters = (
            ("seed", seed),
            ("length", length),
            ("segment_length", lengths),
            ("slope_deg", slopes),
            ("rise", rises),
            ("step_probability", probability),
            ("roughness", roughness),
            ("spacing", spacing),
        )
        return _chained(rows, "random", parameters)

    @classmethod
    def from_file(cls, path: str | Path) -> Terrain:
        """Read a terrain from a file.

        `.csv`: elevation samples, two columns x and z in m with x ascending; an x given twice is a vertical step; a
        header, blank lines and # comments are allowed. The profile is kept as sampled, heights included, and the ground
        ends at the last sample.
        `.toml`, `.yaml`, `.yml`: `segments`, a list of [length, slope_deg, step] or of tables with these keys, as for
        `from_segments`.

        Raises:
            InputError: The file cannot be read, or holds anything else; the message names the file and the line or
                segment.
        """
        if not isinstance(path, str | Path):
            raise InputError(f"a terrain file must be given as its path, got {shown(path)}")
        path = Path(path)
        suffix = path.suffix.lower()
        try:
            if suffix == ".csv":
                return cls._from_samples(path)
            if suffix in FILE_SUFFIXES:
                rows = _checked_segments(read_segments(path))
                return _chained(rows, path.name, (("segments", rows),))
            raise InputError(f"unknown suffix {shown(suffix)}: valid are {', '.join(FILE_SUFFIXES)}")
        except InputError as error:
            raise InputError(f"terrain file {shortened(str(path))}: {error}") from error

    @classmethod
    def _from_samples(cls, path: Path) -> Terrain:
        """Make a terrain that runs through the samples of a CSV file."""
        x, z, angles = [], [], []
        samples = read_samples(path)
        for here, there in pairwise(samples):
            where = f"lines {here.line} to {there.line}"
            if there.x == here.x:
                domains.STEP.check(f"{where}: the step", there.z - here.z)
                continue
            angle = math.atan2(here.z - there.z, there.x - here.x)
            _check_slope(where, angle)
            x.append(here.x)
            z.append(here.z)
            angles.append(angle)
        return cls(tuple(x), tuple(z), tuple(angles), end=samples[-1].x, name=path.name)

    @classmethod
    def preset(cls, name: str, **parameters: Any) -> Terrain:
        """Make a terrain by the name that it has in `PRESETS`, with that constructor's parameters.

        Raises:
            InputError: An unknown name or parameter, with the valid ones listed, or a value outside its domain.
        """
        make = PRESETS[known_name("terrain", name, PRESETS)]
        for key in parameters:
            known_name(f"parameter of the terrain {name}", key, signature(make).parameters)
        try:
            return make(**parameters)
        except InputError as error:
            raise InputError(f"terrain {name}: {error}") from error

    # ---- asking it -----------------------------------------------------------------------------------------------

    @cached_property
    def profile(self) -> Profile:
        """Starts, heights and gradients of the segments, for code that runs at every physics step."""
        return Profile(self.x, self.z, self.gradients)

    @cached_property
    def gradients(self) -> tuple[float, ...]:
        """dz/dx of the segments, shape (n,)."""
        return tuple(-math.tan(angle) for angle in self.angle)

    @cached_property
    def heights_before(self) -> tuple[float, ...]:
        """Heights just before the segments' starts, before the steps, m, shape (n,); the first is z[0]."""
        dx = (there - here for here, there in pairwise(self.x))
        before = (z + g * length for z, g, length in zip(self.z, self.gradients, dx, strict=False))
        return (self.z[0], *before)

    @cached_property
    def rises(self) -> tuple[float, ...]:
        """Steps up at the segments' starts, m, shape (n,); exactly 0.0 where there is none, and for the first."""
        jumps = (after - before for after, before in zip(self.z, self.heights_before, strict=True))
        return tuple(jump if abs(jump) > STEP_RESOLUTION else 0.0 for jump in jumps)

    @cached_property
    def _arrays(self) -> tuple[NDArray[np.float64], ...]:
        """x, z, gradients and angles as arrays."""
        return tuple(np.array(values) for values in (self.x, self.z, self.gradients, self.angle))

    @property
    def caption(self) -> str:
        """The name and the parameters in one line; a list of segments only by its number."""
        shown = ", ".join(
            f"{len(v)} segments"
            if key == "segments" and isinstance(v, tuple)
            else f"{key}={'..'.join(map(str, v)) if isinstance(v, tuple) else v}"
            for key, v in self.parameters
        )
        return " ".join((f"{self.name} ({shown})" if shown else self.name).split())

    def segment_at(self, x: float) -> int:
        """Return the index of the segment under x (m)."""
        return max(bisect_right(self.x, x) - 1, 0)

    def height_at(self, x: float) -> float:
        """Return the height (m) at x (m): `height` for one plain float, without NumPy; NaN gives NaN."""
        return height_of(self.profile, self.segment_at(x), x)

    def slope_at(self, x: float) -> float:
        """Return the slope (rad) at x (m): `slope` for one plain float, without NumPy; NaN gives NaN."""
        return self.angle[self.segment_at(x)] if x == x else x

    @overload
    def height(self, x: float) -> float: ...
    @overload
    def height(self, x: NDArray[Any] | Sequence[float]) -> NDArray[np.float64]: ...
    def height(self, x: float | NDArray[Any] | Sequence[float]) -> float | NDArray[np.float64]:
        """Return the height of the ground.

        Args:
            x: Places, m, any shape; NaN gives NaN.

        Returns:
            Heights, m, in x's shape; a float for a scalar. On a step, the height after it.

        Raises:
            InputError: x is not numeric.
        """
        at = _places(x)
        if at.ndim == 0:
            return self.height_at(float(at))
        starts, heights, gradients, _ = self._arrays
        i = np.maximum(np.searchsorted(starts, at, side="right") - 1, 0)
        with np.errstate(invalid="ignore"):  # level ground at infinity has no height: NaN, as in height_at
            return np.asarray(heights[i] + gradients[i] * (at - starts[i]))

    @overload
    def slope(self, x: float) -> float: ...
    @overload
    def slope(self, x: NDArray[Any] | Sequence[float]) -> NDArray[np.float64]: ...
    def slope(self, x: float | NDArray[Any] | Sequence[float]) -> float | NDArray[np.float64]:
        """Return the slope of the ground.

        Args:
            x: Places, m, any shape; NaN gives NaN.

        Returns:
            Slopes, rad, positive downwards in the walking direction, in x's shape; a float for a scalar. At a break,
            the slope after it.

        Raises:
            InputError: x is not numeric.
        """
        at = _places(x)
        if at.ndim == 0:
            return self.slope_at(float(at))
        starts, _, _, angles = self._arrays
        i = np.maximum(np.searchsorted(starts, at, side="right") - 1, 0)
        return np.where(np.isnan(at), at, angles[i])

    def stretches(self) -> Iterator[range]:
        """Iterate over the runs of segments between two steps, each as the range of its segments' indices."""
        starts = [0, *(i for i, rise in enumerate(self.rises) if rise), len(self.x)]
        return (range(first, stop) for first, stop in pairwise(starts))

    # ---- the record ----------------------------------------------------------------------------------------------

    def to_dict(self) -> dict[str, Any]:
        """Return the fields as JSON can hold them, an `end` at infinity as None; `from_dict` undoes it exactly."""
        return {
            "x": list(self.x),
            "z": list(self.z),
            "angle": list(self.angle),
            "end": self.end if math.isfinite(self.end) else None,
            "name": self.name,
            "parameters": [[key, _thawed(value)] for key, value in self.parameters],
        }

    @classmethod
    def from_dict(cls, fields: Mapping[str, Any]) -> Terrain:
        """Make the terrain that `to_dict` wrote.

        Raises:
            InputError: A field is missing or unknown, or a value is outside its domain.
        """
        names = ("x", "z", "angle", "end", "name", "parameters")
        if not isinstance(fields, Mapping):
            raise InputError(f"a terrain's record must be a mapping with {', '.join(names)}, got {shown(fields)}")
        for key in fields:
            known_name("field of a terrain", key, names)
        missing = [key for key in names if key not in fields]
        if missing:
            raise InputError(f"a terrain's record lacks {', '.join(missing)}; it has {', '.join(names)}")
        try:
            return cls(**{**fields, "end": math.inf if fields["end"] is None else fields["end"]})
        except InputError as error:
            raise InputError(f"not a terrain's record: {error}") from error


PRESETS: Mapping[str, Callable[..., Terrain]] = MappingProxyType(
    {
        "level": Terrain.level,
        "incline": Terrain.incline,
        "slopes": Terrain.slopes,
        "stairs": Terrain.stairs,
        "mixed": Terrain.mixed,
        "random": Terrain.random,
    }
)
"""The terrains that have a name on the command line."""


def parse_terrain(text: str) -> Terrain:
    """Make the terrain that a text on the command line means.

    Args:
        text: A preset ("mixed"), a preset with parameters ("stairs:tread=1.8,rise=-0.06",
            "random:seed=3,slope_deg=-2..2"; a range is low..high), or the path of a terrain file.

    Raises:
        InputError: Neither a preset nor a file; or what the preset or the file refuses.
    """
    text = text.strip()
    name, colon, rest = text.partition(":")
    if name.strip() in PRESETS:
        try:
            parameters = parse_parameters(rest) if colon else {}
        except InputError as error:
            raise InputError(f"terrain {name.strip()}: {error}") from error
        return Terrain.preset(name.strip(), **parameters)
    suffix = Path(text).suffix.lower()
    if suffix in FILE_SUFFIXES or (not colon and (suffix or "/" in text)):
        return Terrain.from_file(text)
    try:
        return Terrain.preset(name.strip())
    except InputError as error:
        raise InputError(f"{error}; or the path of a terrain file ({', '.join(FILE_SUFFIXES)})") from error


def _check_slope(where: str, angle: float) -> None:
    """Refuse a slope (rad) that cannot be stood on."""
    if not abs(angle) < STEEPEST_SLOPE:
        raise InputError(
            f"{where}: a slope of {math.degrees(angle):.4g} degrees is steeper than the robot can stand on at friction "
            f"{GROUND_FRICTION:g}; expected less than {math.degrees(STEEPEST_SLOPE):.1f} degrees up or down"
        )


def _checked_slope(what: str, degrees: object) -> float:
    """Check a slope in degrees and return it as a plain float."""
    slope = domains.SLOPE_DEG.check(what, degrees)
    _check_slope(what, math.radians(slope))
    return slope


def _checked_segments(segments: Iterable[object]) -> list[tuple[float, float, float]]:
    """Check segments as users give them and return them as (length, slope in degrees, step) of plain floats."""
    rows = []
    if isinstance(segments, str | Mapping) or not isinstance(segments, Iterable):
        raise InputError(f"segments must be a list of (length_m, slope_deg, step_up_m), got {shown(segments)}")
    for k, segment in enumerate(segments, start=1):
        values: tuple[Any, ...] = (
            () if isinstance(segment, str) or not isinstance(segment, Iterable) else tuple(segment)
        )
        if len(values) not in (2, 3):
            raise InputError(f"segment {k} is {shown(segment)}; expected (length_m, slope_deg, step_up_m)")
        length = domains.STRETCH.check(f"segment {k}: length", values[0])
        slope = _checked_slope(f"segment {k}: slope", values[1])
        step = domains.STEP.check(f"segment {k}: step", (*values, 0.0)[2])
        rows.append((length, slope, step))
    if not rows:
        raise InputError("there are no segments; give at least one (length_m, slope_deg, step_up_m)")
    return rows


def _chained(rows: Sequence[tuple[float, float, float]], name: str, parameters: tuple[tuple[str, Any], ...]) -> Terrain:
    """Lay checked segments (length, slope in degrees, step) one after another from x = 0."""
    x, z, angles = [0.0], [rows[0][2]], [math.radians(rows[0][1])]
    for (length, _, _), (_, slope, step) in pairwise(rows):
        dx = length * math.cos(angles[-1])
        x.append(x[-1] + dx)
        # the same expression as in heights_before, so that no step is exactly no step
        z.append(z[-1] - math.tan(angles[-1]) * (x[-1] - x[-2]) + step)
        angles.append(math.radians(slope))
    return Terrain(tuple(x), tuple(z), tuple(angles), name=name, parameters=parameters)


def _roughened(
    rows: Sequence[tuple[float, float, float]], spacing: float, height: Callable[[], float]
) -> list[tuple[float, float, float]]:
    """Cut all segments but the first into cells of about `spacing` and add a random height where two cells meet."""
    rough = [rows[0]]
    added = 0.0
    for k, (length, slope, step) in enumerate(rows[1:], start=1):
        cells = max(1, round(length / spacing))
        angle = math.radians(slope)
        dx = length * math.cos(angle) / cells
        for cell in range(cells):
            last = k == len(rows) - 1 and cell == cells - 1
            before, added = added, 0.0 if last else height()
            dz = (added - before) - math.tan(angle) * dx
            rough.append((math.hypot(dx, dz), math.degrees(math.atan2(-dz, dx)), step if cell == 0 else 0.0))
    return [*rough, (1.0, rows[-1][1], 0.0)]


def _listed(name: str, values: object) -> tuple[Any, ...]:
    """Return the entries of a list, tuple or row of an array."""
    if not isinstance(values, str | bytes | Mapping) and isinstance(values, Iterable):
        with suppress(TypeError):  # an array of no dimension
            return tuple(values)
    raise InputError(f"{name} = {shown(values)}: must be a list")


def _places(x: object) -> NDArray[np.float64]:
    """Return x as an array of floats."""
    try:
        places = np.asarray(x)
    except (ValueError, TypeError) as error:
        raise InputError(f"x = {shown(x)}: must be numbers in m") from error
    if places.dtype.kind not in "iuf":
        raise InputError(f"x = {shown(x)}: must be numbers in m")
    return places.astype(np.float64)


def _frozen_pairs(pairs: object) -> tuple[tuple[str, Any], ...]:
    """Check parameters, which are pairs of a name and a value."""
    listed = [(pair, _listed("a terrain's parameter", pair)) for pair in _listed("parameters", pairs)]
    for pair, parts in listed:
        if len(parts) != 2 or not isinstance(parts[0], str):
            raise InputError(f"a terrain's parameter is {shown(pair)}; expected a pair of a name and a value")
    return tuple((name, _frozen(value)) for _, (name, value) in listed)


def _frozen(value: Any, depth: int = 0) -> Any:
    """Turn lists into tuples and NumPy scalars into plain ones, so that parameters can be compared and hashed."""
    if isinstance(value, list | tuple) and depth < _DEEPEST:
        return tuple(_frozen(v, depth + 1) for v in value)
    value = value.item() if isinstance(value, np.generic) else value
    if not isinstance(value, str | int | float | None) or value != value:
        raise InputError(f"a terrain's parameter holds {shown(value)}; expected numbers, text, None and tuples of them")
    return value


def _thawed(value: Any) -> Any:
    """Turn tuples into lists, as JSON has them."""
    return [_thawed(v) for v in value] if isinstance(value, tuple) else value
