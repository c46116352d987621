"""The commands `export`, `report` and `figures`: files for other programs and people."""

from __future__ import annotations

import shlex
import time
from functools import partial
from pathlib import Path
from typing import Annotated

import click

from mjbiped.cli import options
from mjbiped.cli.commands import Given, command, output, to_write
from mjbiped.cli.main import INTERRUPTED, main
from mjbiped.cli.results import Figures, Results
from mjbiped.cli.walkers import robot_of, terrain_of
from mjbiped.errors import InputError, shown
from mjbiped.exchange import MODULES
from mjbiped.records.record import Walk
from mjbiped.utils.parallel import progress_bar

_SCENE, _ROBOT = ".xml", ".urdf"

_FILE = output(_SCENE, _ROBOT, *MODULES)


@command("export")
def export(
    source: Annotated[tuple[str, ...], str, "[SOURCE]"],
    file: Annotated[Path, _FILE],
    /,
    *,
    scene: Annotated[Given, [*options.SCENE, *options.ROBOT]],
    results: Results,
) -> None:
    """Write a scene, a robot or a record to FILE, for other programs.

    The suffix of FILE says what is written. SOURCE is a record, an .npz file, or a TERRAIN as for `mjbiped walk`.

    \b
      .xml      robot and ground of SOURCE ("mixed" if left out) as one MJCF file, for plain MuJoCo
      .urdf     robot alone, given by options or a record, for ROS and simulators
      .csv      samples of a record, with its touchdowns in a second file FILE_touchdowns
      .parquet  the same; needs pip install 'mjbiped[data]'
      .mcap     a record as ROS 2 messages, for Foxglove, PlotJuggler, Rerun, RViz; needs pip install 'mjbiped[ros]'

    \b
    Examples:
      mjbiped export incline:slope_deg=2 scene.xml
      mjbiped export stairs:rise=0.04 scene.xml --robot kneed --initial rest
      mjbiped export kneed.urdf --robot kneed
      mjbiped export walk.npz scene.xml
      mjbiped export walk.npz walk.csv
      mjbiped export walk.npz walk.mcap
    """  # noqa: D301 (click reads the backspace)
    if len(source) > 1:
        raise click.UsageError(f"{len(source)} sources are given, {' and '.join(source)}; give one, then FILE.")
    named, walk = source[0] if source else "", None
    if named.endswith(".npz"):
        scene.refuse(scene, "a TERRAIN", f"the record {named}")
        walk = Walk.load(named)
    robot = robot_of(scene) if walk is None else walk.robot
    if file.suffix in MODULES:
        if walk is None:
            raise click.UsageError(
                f"{file} holds the samples of a walk: give the walk's record, as mjbiped export walk.npz {file}."
            )
        results.save(walk, file)
    elif file.suffix == _ROBOT:
        from mjbiped.exchange.ros import export_urdf  # which loads an engine, as the next does

        if walk is None and named:
            raise click.UsageError(f"{file} is of a robot alone; leave {shown(named)} out, or give a record.")
        scene.refuse(scene, f"scenes ({_SCENE})", str(file))
        results.write("robot", file, partial(export_urdf, robot))
    else:
        from mjbiped.exchange.mjcf import export_scene

        terrain = terrain_of(named or "mixed", scene.get("seed")) if walk is None else walk.terrain
        initial = scene.get("initial", "gait") if walk is None else walk.settings["initial"]
        results.write("scene", file, partial(export_scene, robot, terrain, initial=initial))
    results.end({}, [])


@command("report")
def report(
    source: Annotated[Path, options.FILE, "RECORD"],
    /,
    *,
    out: Annotated[Path | None, output(".html")] = None,
    no_video: bool = False,
    results: Results,
) -> None:
    """Write an interactive page about the walk of RECORD, an .npz file, or about a study: the folder of a sweep.

    The page holds all that it needs: it opens without a server and without a network, and can be sent as it is. It
    needs Plotly and Jinja: pip install 'mjbiped[report]'. The page "reports" of the documentation says what is on it.

    Results:
        out: The page, an .html file; unless given, beside RECORD with its name (for a folder: in it).
        no_video: Leave out the video, which takes longest.

    \b
    Examples:
      mjbiped report walk.npz
      mjbiped report walk.npz --no-video --out pages/walk.html
      mjbiped report out/random_ground
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.reports.study import report_study
    from mjbiped.reports.walk import report_walk

    if source.suffix.lower() == ".toml":
        raise InputError(
            f"{shown(str(source))} is a study's file: expected is the folder of its sweep, which is "
            f"{source.with_suffix('')} unless `mjbiped sweep` was told another"
        )
    study = source.is_dir()
    if study and no_video:
        raise click.UsageError("--no-video is for the report of a walk; that of a study has no video.")
    page = out or to_write(source / "report.html" if study else source.with_suffix(".html"), ".html")
    walked = partial(report_walk, video=not no_video, progress=not results.quiet)
    results.write("report", page, partial(report_study, source) if study else partial(walked, Walk.load(source)))
    results.end({}, [])


SET = {
    "gait": "gait --slope-deg 2",
    "gait_knees": "gait --robot kneed --slope-deg 2.5",
    "gait_wheel": "gait --robot wheel --slope-deg 5",
    "reference": "reference --clearance 0.06",
    "return_map": "return-map --slope-deg 3.2 --steps 100",
    "return_map_knees": "return-map --robot kneed --slope-deg 6 --steps 100",
    "bifurcation": "bifurcation --slopes 400 --plot-multipliers {folder}/multipliers.pdf",
    "bifurcation_knees": "bifurcation --robot kneed --slopes 400 --plot-multipliers {folder}/multipliers_knees.pdf",
    "basin": "basin --slope-deg 2 --grid 150",
    "basin_knees": "basin --robot kneed --slope-deg 2.5 --grid 100",
    "basin_controlled": "basin --controller adaptive --grid 40",
    "walk": "walk mixed --initial rest --out {folder}/walk.npz",
    "walk_knees": "walk stairs:rise=0.04 --robot kneed --engine hybrid --steps 20",
    "comparison": "compare mixed --steps 18",
    "stability": "stability {folder}/walk.npz",
}
"""Commands by the names of the figures that they draw; each is given its `--plot`."""


@command("figures")
def figures(folder: Annotated[Path, options.FOLDER], /, *, results: Figures) -> None:
    """Draw the whole set of figures into FOLDER, as PDF for slides and papers.

    Gaits, return maps, bifurcations, basins, walks, both engines compared, and Theorem 1, with straight legs and with
    knees. Another command draws each figure; the summary lists these commands, so that you can redraw single figures
    with other options. The set takes some minutes.

    \b
    Examples:
      mjbiped figures slides
      mjbiped figures paper --plot-width single
    """  # noqa: D301 (click reads the backspace)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{shown(str(folder))} cannot be made: {error.strerror}; give another folder") from error
    done: list[dict[str, str | float]] = []
    with progress_bar(total=len(SET), desc="figures", progress=not results.quiet) as bar:
        for name, words in SET.items():
            bar.set_postfix_str(name, refresh=False)
            told = [word.format(folder=folder) for word in words.split()] + ["--plot", str(folder / f"{name}.pdf")]
            began = time.perf_counter()
            # which says what is wrong
            status = main.main([*told, "--plot-width", results.plot_width, "--quiet"], standalone_mode=False)
            if status == INTERRUPTED:
                results.fail(INTERRUPTED, f"interrupted in mjbiped {told[0]}; the figures before it are written")
                break
            if status:
                results.fail(status, f"mjbiped {told[0]} failed")
            else:
                results.written |= {Path(word).name: word for word in told if word.startswith(f"{folder}/")}
                done.append({"command": f"mjbiped {shlex.join(told)}", "seconds": time.perf_counter() - began})
            bar.update()
    results.end({"figures": done}, [f"{each['seconds']:6.1f} s  {each['command']}" for each in done])
