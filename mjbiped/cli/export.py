"""The command `export`: scenes, robots and records in the formats of other programs."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import click

from mjbiped.cli import kinds, options, sections
from mjbiped.cli.files import Results
from mjbiped.cli.sections import SectionCommand, refuse, results, section
from mjbiped.cli.walkers import robot_of, terrain_of
from mjbiped.errors import shown
from mjbiped.exchange.mjcf import export_scene
from mjbiped.exchange.records import MODULES, check_format
from mjbiped.exchange.urdf import export_urdf
from mjbiped.records.record import Walk

_SCENE, _ROBOT = ".xml", ".urdf"
_RECORD = ".npz"
_OF_SCENES = "Scene"


@click.command("export", cls=SectionCommand)
@click.argument("source", nargs=-1, metavar="[SOURCE]")
@click.argument("file", type=kinds.output(_SCENE, _ROBOT, *MODULES))
@sections.options(_OF_SCENES, options.SEED, options.INITIAL)
@options.robot_options
@results(options.QUIET)
@click.pass_context
def export(ctx: click.Context, /, source: Sequence[str], file: Path, results: Results, **values: Any) -> None:
    """Write a scene, a robot or a record to FILE, for other programs.

    The suffix of FILE says what is written. SOURCE is a record, an .npz file, or a TERRAIN as for `mjbiped walk`.

    \b
      .xml      robot and ground of SOURCE ("mixed" if left out) as one MJCF file, for plain MuJoCo
      .urdf     robot alone, of the options or of a record, for ROS and simulators
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
    named = source[0] if source else ""
    walk = None
    if named.endswith(_RECORD):
        of_terrains = [each for each in ctx.command.params if each.name not in ("source", "file", "quiet")]
        refuse(ctx, of_terrains, "a TERRAIN", f"the record {named}")
        walk = Walk.load(named)
    robot = robot_of(ctx, values) if walk is None else walk.robot
    if file.suffix in MODULES:
        if walk is None:
            raise click.UsageError(f"{file} is of a walk: give its record, as mjbiped export walk.npz {file}.")
        results.out = check_format(file)
        results.save(walk)
    elif file.suffix == _ROBOT:
        if walk is None and named:
            raise click.UsageError(f"{file} is of a robot alone; leave {shown(named)} out, or give a record.")
        refuse(ctx, section(ctx, _OF_SCENES), f"scenes ({_SCENE})", str(file))
        results.write("robot", file, partial(export_urdf, robot))
    else:
        terrain = terrain_of(named or "mixed", values["seed"]) if walk is None else walk.terrain
        initial = values["initial"] if walk is None else walk.settings["initial"]
        results.write("scene", file, partial(export_scene, robot, terrain, initial=initial))
    results.end({}, [])
