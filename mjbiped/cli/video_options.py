"""Options of videos on the command line."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import click

from mjbiped.cli.kinds import Kind, output
from mjbiped.cli.sections import options
from mjbiped.errors import InputError, shown
from mjbiped.rendering.look import ALL, ELEMENTS, SUFFIXES, look
from mjbiped.terrain.files import parse_number
from mjbiped.utils import domains

VIDEO_PATH = output(*SUFFIXES)
CAMERAS = ("track", "side", "overview")


def size(value: str) -> tuple[int, int]:
    """Width and height in pixels, as "640x480"; H.264 wants them even."""
    width, _, height = value.lower().partition("x")
    try:
        sizes = [domains.PIXELS.check("", parse_number(part)) for part in (width, height)]
    except InputError:
        sizes = [1]
    if any(size % 2 for size in sizes):
        least, most = domains.PIXELS.low, domains.PIXELS.high
        wanted = f"WIDTHxHEIGHT, even pixels from {least} to {most} each, as 1280x720"
        raise click.BadParameter(f"{shown(value)}; expected {wanted}.")
    return sizes[0], sizes[1]


def _of_look(argument: str) -> Callable[[str], str]:
    """What reads names that `mjbiped.rendering.look.look` takes as an argument, and leaves them as they are written."""

    def read(value: str) -> str:
        try:
            look(**{argument: value})
        except InputError as error:
            raise click.BadParameter(f"{error}.") from error
        return value

    return read


HIDDEN = Kind("NAMES", _of_look("hide"))
"""Names of what a video does not show, parted by commas."""

VISUAL_FLAG = Kind("NAME", _of_look("flags"))
"""The name of one of MuJoCo's visual flags."""

video_options = options(
    "Video",
    ("--video-size", Kind("WxH", size), "1280x720", "Width and height, pixels."),
    ("--camera", click.Choice(CAMERAS), CAMERAS[0], "Where it is seen from."),
    ("--from start", domains.TIME, None, "Time of the walk at which the video begins, s."),
    ("--to stop", domains.TIME, None, "Time of the walk at which it ends, s."),
    ("--slow-motion", domains.SLOW_MOTION, 1.0, "Seconds of video per second of the walk."),
    ("--fps", domains.FPS, 30, "Frames per second."),
    ("--hide", HIDDEN, (), f"What is not shown, parted by commas: {', '.join(ELEMENTS)}, or {ALL}."),
    (
        "--flag flags",
        VISUAL_FLAG,
        (),
        "A visual flag of MuJoCo's to set, as contactpoint, shadow or wireframe; with no- before it to clear, as "
        "no-skin; may be repeated.",
    ),
)
"""Options of a video, named as the arguments of `mjbiped.rendering.video.render_video`, `video_size` apart."""


def check_part(values: Mapping[str, Any]) -> None:
    """Refuse a video that ends before it begins.

    Raises:
        click.UsageError: It does.
    """
    start, stop = values["start"], values["stop"]
    if start is not None and stop is not None and start > stop:
        raise click.UsageError(f"--from {start:g} comes after --to {stop:g}; swap them.")


video_option = options("Results", ("--video", VIDEO_PATH, None, "Write a video, .mp4 or .gif; see below."))
no_video_option = options("Results", ("--no-video", bool, False, "Write the figure only."))
video_argument = click.argument("video", required=False, type=VIDEO_PATH)
