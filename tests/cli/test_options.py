"""Options agree with what they set."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import mujoco

import mjbiped
from mjbiped.cli import main as cli
from mjbiped.cli import options as cli_options
from mjbiped.engines.mujoco import scene
from mjbiped.plotting import style as plot_style


def test_options_agree_with_what_they_set() -> None:
    options = {parameter.name: parameter for parameter in cli.main.commands["walk"].params}
    sections = {name: getattr(parameter, "section", "") for name, parameter in options.items()}
    for kind in (mjbiped.Compass, mjbiped.KneedBiped, mjbiped.RoundCompass, mjbiped.RoundKneed, mjbiped.RimlessWheel):
        mine = re.compile(rf"Robot( .*(?<!\S){kind.kind}(,.*)?)?")
        told = {name for name, section in sections.items() if mine.fullmatch(section)}
        assert told - {"robot"} == {field.name for field in dataclasses.fields(kind)}
    for suffix in plot_style.SUFFIXES:
        assert options["plot"].type(f"walk{suffix}", options["plot"], None) == Path(f"walk{suffix}")
    model = mujoco.MjModel.from_xml_path(str(scene.models_folder() / "scene.xml"))
    assert {model.camera(index).name for index in range(model.ncam)} == set(cli_options.CAMERAS)
