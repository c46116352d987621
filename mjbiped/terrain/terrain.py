"""The ground: a piecewise-linear profile with vertical steps, x forward and z up.

Slope > 0 goes down in the walking direction (dz/dx = -tan slope), step > 0 goes up: the signs of the paper's Fig. 4.
For robots in space the ground may fall to one side as well, and a surface z(x, y) may lie on it. Lateral slope > 0 goes
down to the left, which is +y (dz/dy = -tan lateral). The profile, without the surface, is the ground at y = 0.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from mjbiped.errors import InputError, prefixed, shortened, shown
from mjbiped.terrain.drawn import recorded_rows
from mjbiped.terrain.files import FILE_SUFFIXES, parse_parameters, read_grid, read_profile, read_segments
from mjbiped.terrain.presets import PRESETS, Presets
from mjbiped.terrain.profile import (
    HIGHEST_STEP,
    MOST_SEGMENTS,
    check_slope,
    checked_segments,
)
from mjbiped.terrain.shape import STEP_RESOLUTION, Shape
from mjbiped.terrain.surface import Length, Seed, Surface
from mjbiped.utils import domains
from mjbiped.utils.domains import Domain, checked, entries, known_name

SHORTEST_RECORD = 5.0
"""Shortest record from which random ground is made, m: some steps."""

_FIELDS = {"x": domains.PLACE, "z": domains.PLACE, "angle": domains.ANGLE, "lateral": domains.ANGLE}
_IN_SPACE = ("lateral", "surface")  # fields that records of profiles do not have
_RISE = Domain(-HIGHEST_STEP - STEP_RESOLUTION, HIGHEST_STEP + STEP_RESOLUTION, "m")  # a difference of rounded heights


@dataclass(frozen=True)
class Terrain(Presets, Shape):
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
        name: Name in records and captions.
        parameters: Pairs (name, value) that it was made with, for records and captions; nested tuples of plain values.
        lateral: Slope angles across, of the segments, rad, shape (n,); positive goes down to the left. Empty where all
            ground is level across.

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
    lateral: tuple[float, ...] = ()
    surface: Surface | None = None

    def __post_init__(self) -> None:
        """Check the fields, and make plain tuples of them."""
        for field, domain in _FIELDS.items():
            values = _listed(field, getattr(self, field))
            if len(values) > MOST_SEGMENTS:
                raise InputError(
                    f"the terrain has {len(values)} segments; at most {MOST_SEGMENTS} are possible, make them longer"
                )
            checked = tuple(domain.check(f"segment {i}: {field}", value) for i, value in enumerate(values, start=1))
            object.__setattr__(self, field, checked)
        n = len(self.x)
        if not n or len(self.z) != n or len(self.angle) != n:
            raise InputError(
                f"x, z and angle must have the same number of entries, at least one; got {n}, {len(self.z)} and "
                f"{len(self.angle)}"
            )
        endless = isinstance(self.end, float) and self.end == math.inf
        object.__setattr__(self, "end", math.inf if endless else domains.PLACE.check("end", self.end))
        for i, (here, there) in enumerate(pairwise((*self.x, self.end)), start=1):
            if not here < there:
                raise InputError(f"segment {i}, from x = {here:.17g} to {there:.17g} m, must have a length > 0")
        if not self.x[0] <= 0.0 < self.end:
            raise InputError(
                f"the ground reaches from x = {self.x[0]:g} to {self.end:g} m, but the robot starts at x = 0; subtract "
                "the x of the robot's start from all x"
            )
        if not any(self.lateral):
            object.__setattr__(self, "lateral", ())
        elif len(self.lateral) != n:
            raise InputError(f"lateral must be empty, or have an entry per segment, {n}; got {len(self.lateral)}")
        for i, angle in enumerate(self.angle, start=1):
            check_slope(f"segment {i}", angle)
        for i, (gradient, aside) in enumerate(zip(self.gradients, self.lateral, strict=False), start=1):
            check_slope(f"segment {i}", math.atan(math.hypot(gradient, math.tan(aside))))
        if self.surface is not None:
            self._check_surface(self.surface)
        for i, rise in enumerate(self.rises, start=1):
            _RISE.check(f"segment {i}: its step", rise)
        domains.check_text("name", self.name)
        pairs = _frozen(self.parameters)
        if not isinstance(pairs, tuple) or not all(
            isinstance(pair, tuple) and len(pair) == 2 and isinstance(pair[0], str) for pair in pairs
        ):
            raise InputError(f"parameters = {shown(pairs)}: expected pairs of a name and a value")
        object.__setattr__(self, "parameters", pairs)

    def _check_surface(self, surface: object) -> None:
        """Refuse a surface on more than a plane, beside the robot's start, or too steep to be stood on."""
        if not isinstance(surface, Surface):
            raise InputError(f"surface = {shown(surface)}: must be a Surface or None")
        if len(self.x) > 1:
            raise InputError(f"a surface lies on a single segment, and this ground has {len(self.x)}")
        last_x, last_y = surface.ends
        if not (surface.x0 <= 0.0 < last_x and surface.y0 <= 0.0 < last_y):
            raise InputError(
                f"the surface reaches from x = {surface.x0:g} to {last_x:g} m and from y = {surface.y0:g} to "
                f"{last_y:g} m, but the robot starts at x = 0, y = 0"
            )
        fall = self.falls[0] if self.lateral else 0.0
        angle, x, y = surface.steepest(self.gradients[0], -fall)
        check_slope(f"at x = {x:g}, y = {y:g} m", angle)

    def __repr__(self) -> str:
        """One line without the profile, which can be long; `to_dict` contains it."""
        count = f"{len(self.x)} segment{'' if len(self.x) == 1 else 's'}"
        reach = f"up to x = {self.end:g} m" if math.isfinite(self.end) else "without end"
        return f"<Terrain {self.caption}: {count} {reach}>"

    @property
    def caption(self) -> str:
        """Name and parameters in one line; of a list of segments only the number."""
        shown = ", ".join(
            f"{len(v)} segments"
            if key == "segments" and isinstance(v, tuple)
            else f"{key}={'..'.join(map(str, v)) if isinstance(v, tuple) else v}"
            for key, v in self.parameters
        )
        return " ".join((f"{self.name} ({shown})" if shown else self.name).split())

    # ---- making one ----------------------------------------------------------------------------------------------

    @classmethod
    def from_segments(cls, segments: Iterable[Sequence[float]], name: str = "segments") -> Terrain:
        """Make a terrain from consecutive segments, the first from x = 0.

        Args:
            segments: One (length, slope, step, lateral slope) per segment: the length along the ground in m, > 0;
                the slope in degrees, positive downwards; the step up in m at the segment's start; and the slope across
                in degrees, positive down to the left. Step and lateral slope are 0 if left out. The first segment has
                no riser, since it extends backwards: its step is the height at x = 0. The last one goes on beyond its
                length.
            name: Name of the terrain.

        Raises:
            InputError: No segments, or a value outside its domain; the message names the segment, counted from 1.
        """
        rows = checked_segments(segments)
        return cls._of_segments(rows, name, {"segments": rows})

    @classmethod
    def from_file(cls, path: str | Path) -> Terrain:
        """Read a terrain from a file.

        `.csv`: elevation samples, two columns x and z in m with x ascending; an x given twice is a vertical step; a
        header, blank lines and # comments are allowed. The profile is kept as sampled, heights included, and the ground
        ends at the last sample.
        `.asc`: a surveyed grid, an ESRI ASCII grid; see `mjbiped.terrain.files.read_grid`. The ground ends at its last
        column.
        `.toml`, `.yaml`, `.yml`: `segments`, a list of [length, slope_deg, step, lateral_deg] or of tables with these
        keys, as for `from_segments`.

        Raises:
            InputError: The file cannot be read, or holds anything else; the message names the file and the line or
                segment.
        """
        if not isinstance(path, str | Path):
            raise InputError(f"a terrain file must be given as its path, got {shown(path)}")
        path = Path(path)
        suffix = path.suffix.lower()
        with prefixed(f"terrain file {shortened(str(path))}: "):
            known_name("suffix", suffix, FILE_SUFFIXES)
            if suffix == ".csv":
                x, z, angles, end = read_profile(path)
                return cls(x, z, angles, end=end, name=path.name)
            if suffix == ".asc":
                surface = read_grid(path)
                return cls((surface.x0,), (0.0,), (0.0,), end=surface.ends[0], name=path.name, surface=surface)
            rows = checked_segments(read_segments(path))
            return cls._of_segments(rows, path.name, {"segments": rows})

    @classmethod
    @checked
    def recorded(cls, file: str | Path | Terrain | None = None, seed: Seed = 0, length: Length = 400.0) -> Terrain:
        """Make random ground from a recorded elevation profile; the same arguments give the same terrain bit by bit.

        The first 2 m are level. Then comes a stretch of the record without its trend: the straight line that fits the
        samples best is taken away. Each seed takes another stretch, at a random place and in a random direction. At its
        ends the record goes on mirrored, to and fro: stretches of a record that is not much longer than `length` show
        the same ground again and again, and a mean over seeds says nothing of other ground than this.

        Args:
            file: Elevation file (.csv) as `from_file` reads it, or the terrain that it has read.
            seed: Seed of the generator (NumPy's PCG64), >= 0.
            length: Length of the ground along x, m, >= 2; its last slope goes on.

        Raises:
            InputError: The file is no elevation profile, is too short, or would have to be walked too often; or a value
                is outside its domain.
        """
        if file is None:
            raise InputError("recorded ground needs an elevation file: recorded:file=trail.csv")
        record = file if isinstance(file, Terrain) else cls.from_file(file)
        if not math.isfinite(record.end):
            raise InputError(f"{shown(record.name)} goes on without end; expected an elevation file (.csv)")
        if not record.is_profile:
            raise InputError(f"{shown(record.name)} is ground in space; expected an elevation file (.csv)")
        reach = record.end - record.x[0]
        if reach < SHORTEST_RECORD:
            raise InputError(
                f"{shown(record.name)} is a record of {reach:g} m; at least {SHORTEST_RECORD:g} m are needed: record a "
                "longer stretch, or walk on the file itself"
            )
        if (length / reach + 1.0) * len(record.x) > MOST_SEGMENTS:
            raise InputError(
                f"{length:g} m of {shown(record.name)} are more than {MOST_SEGMENTS} segments; choose a shorter "
                "length, or a record with fewer samples"
            )
        x, z = record.samples
        rows = recorded_rows(seed, length, x, z)
        return cls._of_segments(rows, "recorded", {"file": record.name, "seed": seed, "length": length})

    # ---- the record ----------------------------------------------------------------------------------------------

    def to_dict(self) -> dict[str, Any]:
        """Return the fields as JSON can hold them; `from_dict` undoes it exactly.

        An `end` at infinity is None; what only ground in space has is left out of a profile.
        """
        written = {field.name: _thawed(getattr(self, field.name)) for field in fields(self)}
        written["end"] = self.end if math.isfinite(self.end) else None
        return {name: value for name, value in written.items() if value or name not in _IN_SPACE}

    @classmethod
    def from_dict(cls, written: Mapping[str, Any]) -> Terrain:
        """Make the terrain that `to_dict` wrote.

        Raises:
            InputError: A field is missing or unknown, or a value is outside its domain.
        """
        names = [field.name for field in fields(cls) if field.name not in _IN_SPACE]
        if not isinstance(written, Mapping) or {*written} - {*_IN_SPACE} != {*names}:
            raise InputError(f"a terrain's record must be a mapping with {', '.join(names)}, got {shown(written)}")
        end, surface = written["end"], written.get("surface")
        with prefixed("not a terrain's record: "):
            again = {"end": math.inf if end is None else end, "surface": surface and Surface.from_dict(surface)}
            return cls(**{**written, **again})


def parse_terrain(text: str) -> Terrain:
    """Make the terrain that a text on the command line describes.

    Args:
        text: A preset ("mixed"), a preset with parameters ("stairs:tread=1.8,rise=-0.06",
            "random:seed=3,slope_deg=-2..2"; a range is low..high), or the path of a terrain file.

    Raises:
        InputError: Neither a preset nor a file; or what the preset or the file refuses.
    """
    text = text.strip()
    name, colon, rest = text.partition(":")
    if name.strip() in PRESETS:
        with prefixed(f"terrain {name.strip()}: "):
            parameters = parse_parameters(rest) if colon else {}
        return Terrain.preset(name.strip(), **parameters)
    suffix = Path(text).suffix.lower()
    if suffix in FILE_SUFFIXES or (not colon and (suffix or "/" in text)):
        return Terrain.from_file(text)
    try:
        return Terrain.preset(name.strip())
    except InputError as error:
        raise InputError(f"{error}; or the path of a terrain file ({', '.join(FILE_SUFFIXES)})") from error


def _listed(name: str, values: object) -> tuple[Any, ...]:
    """Return the entries of a list, tuple or row of an array; refuse anything else."""
    listed = entries(values)
    if listed is None:
        raise InputError(f"{name} = {shown(values)}: must be a list")
    return listed


def _frozen(value: object) -> Any:
    """Turn lists into tuples and NumPy scalars into plain ones, so that parameters can be compared and hashed."""
    if isinstance(value, list | tuple):
        return tuple(map(_frozen, value))
    value = value.item() if isinstance(value, np.generic) else value
    if not isinstance(value, str | int | float | None) or value != value:
        raise InputError(f"a terrain's parameter holds {shown(value)}; expected numbers, text, None and tuples of them")
    return value


def _thawed(value: object) -> object:
    """Turn tuples into lists, as JSON has them, and a surface into what its record holds."""
    if isinstance(value, Surface):
        return value.to_dict()
    return [_thawed(v) for v in value] if isinstance(value, tuple) else value
