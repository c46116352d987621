"""Record of a walk, which every engine returns, in memory and on disk."""

from __future__ import annotations

import json
import textwrap
from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjbiped.errors import LONGEST_SHOWN, MjbipedError, RecordError, shown
from mjbiped.records import measures
from mjbiped.records.arrays import read_arrays, write_arrays
from mjbiped.records.columns import flat_samples, flat_touchdowns, tables_of, units_of
from mjbiped.records.loads import unknown
from mjbiped.records.schema import FORMAT, FORMAT_VERSION, checked_fields
from mjbiped.records.summary import WalkSummary, html_table
from mjbiped.robots.kinds import robot_from
from mjbiped.robots.robot import Robot
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.packages import needed

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

_SHOWN_FIRST = ("outcome", "ended at", "terrain", "controller", "warning", "steps", "distance", "speed",
                "cost of transport, absolute", "peak torque, ankle", "peak torque, hip")  # fmt: skip


class Frames(NamedTuple):
    """A walk as data frames; `attrs["units"]` of each has the units of its columns.

    Attributes:
        samples: A row per sample.
        touchdowns: A row per support transfer.
    """

    samples: pandas.DataFrame
    touchdowns: pandas.DataFrame


@dataclass(frozen=True, eq=False)
class Walk:
    """Walk of a biped, from its start to its outcome.

    Attributes:
        samples: Arrays over time by name, empty where no samples were asked for, with a row per sample:
            `samples["torque"]` has the shape (n, 2) for ankle and hip. `controller_states`, shape (n, k), are the
            controller's integrated states.
        touchdowns: Arrays by name with a row per support transfer. The posture (`q_before`, `q`) is that of the
            touchdown, in the old and the new roles; the rates `dq_before` and `dq` are those before and after the
            impact. docs/tables/columns.md lists the columns of both tables with shapes and units.
        outcome: "finished", "fell", "stalled", "slipped", "left the terrain", "diverged", "unresolved" (the hybrid
            engine could not follow the torques), "time limit" (of an environment's episode) or "interrupted".
        end: Time (s) and hip x (m) when it ended.
        peak_torque: Greatest `|ankle|` and `|hip|` torque, and a swing knee's, of all control ticks, N m.
        pressure_times: Histogram of the centre of pressure that the ankle's torque requires: time in each bin, s, shape
            (130,); see `mjbiped.records.loads`. NaN in records of earlier versions.
        settings: All that is needed to repeat the walk, in plain JSON types: robot, controller, terrain, engine and its
            parameters, initial state, limits, versions.
    """

    samples: Mapping[str, NDArray[Any]]
    touchdowns: Mapping[str, NDArray[Any]]
    outcome: str
    end: tuple[float, float]
    peak_torque: NDArray[np.float64]
    settings: Mapping[str, Any]
    pressure_times: NDArray[np.float64] = field(default_factory=unknown)

    @property
    def robot(self) -> Robot:
        """Robot that walked."""
        return robot_from(self.settings["robot"])

    @property
    def terrain(self) -> Terrain:
        """Ground that the robot walked on."""
        return Terrain.from_dict(self.settings["terrain"])

    @property
    def start(self) -> Mapping[str, float]:
        """Place x and z (m) of the stance foot at the start, slope under it (rad), and time (s)."""
        return measures.start_of(self.terrain)

    @property
    def steps(self) -> int:
        """Number of touchdowns."""
        return len(self.touchdowns["time"])

    @property
    def fell(self) -> bool:
        """Whether the robot fell; other failures have outcomes of their own."""
        return self.outcome == "fell"

    @property
    def warnings(self) -> Mapping[str, int]:
        """Warnings of the engine with their counts, for example why the walk diverged."""
        warnings: Mapping[str, int] = self.settings.get("warnings", {})
        return warnings

    @property
    def ground_pulls(self) -> NDArray[np.bool_]:
        """Whether the ground would have had to pull in the step that each touchdown ends, shape (steps,).

        `touchdowns["normal_force"]` has the least force; see `mjbiped.records.measures.pulls`.
        """
        return measures.pulls(self.touchdowns)

    @property
    def contact_violations(self) -> NDArray[np.bool_]:
        """Whether the step that each touchdown ends violates the contact, shape (steps,).

        The ground would have to pull, or to have friction over 0.8; see `mjbiped.records.measures.violations`.
        """
        return measures.violations(self.touchdowns)

    @property
    def verdict(self) -> str:
        """Outcome; "finished, contact violated" for a finished walk with any of `contact_violations`."""
        return measures.verdict(self.outcome, int(self.contact_violations.sum()))

    @property
    def distance(self) -> float:
        """Horizontal distance of the stance foot, m."""
        return measures.distance(self)

    @property
    def cost_of_transport(self) -> float:
        """Cost of transport c_mt of the absolute work; `mjbiped.records.measures.cost_of_transport` has variants."""
        return measures.cost_of_transport(self)

    def __repr__(self) -> str:
        """Describe the walk in one line."""
        name = textwrap.shorten(self.settings["terrain"]["name"], LONGEST_SHOWN, placeholder="...")
        x = self.distance
        said = "".join(f"; {text}" for text in self.warnings)
        return f"<Walk on {name}: {self.outcome} after {self.steps} steps, {x:.3f} m, {self.end[0]:.3f} s{said}>"

    def summary(self) -> WalkSummary:
        """Compute all measures of the walk.

        Returns:
            What prints as the table of `mjbiped walk`, and has each measure by its name:
            `walk.summary()["cost_of_transport"]`. A measure that does not exist is None.
        """
        return WalkSummary(self)

    def plot(self, path: str | Path | None = None, *, panels: Sequence[str] | None = None) -> Figure:
        """Draw the walk: time lapse, slope estimate, torques, phase portraits.

        Args:
            path: File to write as well, `.png`, `.pdf` or `.svg`.
            panels: Names of its panels, of `mjbiped.records.signals.FIGURE`, as ("torque", "phase").

        Returns:
            The figure; `mjbiped.plotting.walk.plot_walk` describes it.

        Raises:
            InputError: The path has another suffix, or there is no such panel; nothing has been drawn then.
            RenderError: The record holds no samples, or the file cannot be written.
        """
        # by name: a record imports nothing that draws, and what draws imports records
        figure: Figure = resolve_name("mjbiped.plotting.walk:plot_walk")(self, path, panels=panels)
        return figure

    def video(self, path: str | Path | None = None, **settings: object) -> None:
        """Render the walk as a video.

        Args:
            path: File to write, `.mp4` or `.gif`; None shows the video in a notebook.
            **settings: Those of `mjbiped.rendering.video.render_video`: `slow_motion=4`, `camera="side"`,
                `progress=True` and others.

        Raises:
            InputError: An argument is outside its domain; nothing has been drawn then.
            RenderError: The record holds no samples, no OpenGL platform works, or the file cannot be written.
        """
        resolve_name("mjbiped.rendering.video:render_video")(self, path, **settings)

    def to_pandas(self) -> Frames:
        """Return the walk as two data frames of pandas, `samples` and `touchdowns`.

        Columns are flat, one number each: `q_stance`, `q_swing`, `torque_ankle`, `qpos_hip_x`, ..., and
        `controller_state_0`, ... for the controller's integrated states. Both frames have `step`, from 1 on: a sample
        belongs to the step whose stance leg it has, a touchdown to the step that it ends. `frame.attrs["units"]` has
        the units by column; SI and radians throughout.

        Returns:
            A named tuple: `samples, touchdowns = walk.to_pandas()`.

        Raises:
            InputError: pandas is not installed: it comes with `pip install 'mjbiped[data]'`.
        """
        pandas = needed("pandas", "data", "to_pandas")
        made = Frames(pandas.DataFrame(flat_samples(self)), pandas.DataFrame(flat_touchdowns(self)))
        for frame, columns in zip(made, tables_of(type(self.robot)), strict=True):
            frame.attrs["units"] = units_of(columns)
        return made

    def _repr_html_(self) -> str:
        """Return outcome, measures and, if there are samples, the time lapse for a notebook."""
        shown_first = html_table(row for row in self.summary().rows if row[0] in _SHOWN_FIRST)
        try:
            picture = b64encode(resolve_name("mjbiped.plotting.walk:time_lapse_picture")(self)).decode()
        except MjbipedError:  # nothing to draw
            return shown_first
        return f'{shown_first}<img alt="time lapse of the walk" src="data:image/png;base64,{picture}">'

    def __eq__(self, other: object) -> bool:
        """Compare everything recorded, bit by bit, but the command that made the walk."""
        if not isinstance(other, Walk):
            return NotImplemented
        return self._identity() == other._identity()

    __hash__ = None  # type: ignore[assignment]  # arrays are mutable

    def _identity(self) -> object:
        settings = {name: value for name, value in self.settings.items() if name != "command"}
        arrays = replace(self, settings=settings)._arrays(sort_keys=True)
        return [(name, array.dtype.str, array.shape, array.tobytes()) for name, array in sorted(arrays.items())]

    def _arrays(self, *, sort_keys: bool = False) -> dict[str, NDArray[Any]]:
        """Return the arrays of the record's file by name; `sort_keys` puts the settings into alphabetical order."""
        header: dict[str, Any] = {"format": FORMAT, "version": FORMAT_VERSION, "outcome": self.outcome}
        header |= {"end": self.end, "settings": dict(self.settings)}
        return {
            "header": np.array(json.dumps(header, sort_keys=sort_keys)),
            "peak_torque": self.peak_torque,
            "pressure_times": self.pressure_times,
            **{f"samples/{name}": array for name, array in self.samples.items()},
            **{f"touchdowns/{name}": array for name, array in self.touchdowns.items()},
        }

    def save(self, path: str | Path) -> None:
        """Write the record as `.npz`, which appears whole or not at all.

        Args:
            path: File to write; its name must end in `.npz`.

        Raises:
            RecordError: The name has another ending, or the file cannot be written.
        """
        path = Path(path)
        if path.suffix != ".npz":
            raise RecordError(
                f"a walk's record is an .npz file; cannot save as {shown(path.name)}. For other programs: "
                "mjbiped.exchange.export_walk"
            )
        write_arrays(path, self._arrays())

    @classmethod
    def load(cls, path: str | Path) -> Walk:
        """Load a record.

        Args:
            path: File that `save` wrote.

        Returns:
            The same walk.

        Raises:
            RecordError: The file is missing, damaged, not a walk's record, or of a newer version. What is loaded can be
                measured and drawn: `mjbiped.records.schema` says what has been checked.
        """
        path = Path(path)
        arrays = read_arrays(path)
        try:
            return cls(**checked_fields(arrays))
        except RecordError as error:
            raise RecordError(f"{path} {error}") from error
