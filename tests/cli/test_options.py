"""Options agree with what they set."""

from __future__ import annotations

import dataclasses
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
    named = ("", " compass", " kneed, halved-rods", " wheel")
    shared, legs, knees, wheel = ({name for name in sections if sections[name] == f"Robot{each}"} for each in named)
    assert shared == {"robot", "hip_mass", "gravity", "sole"}
    assert legs == {field.name for field in dataclasses.fields(mjbiped.Compass)} - shared
    assert knees == {field.name for field in dataclasses.fields(mjbiped.KneedBiped)} - shared
    assert wheel == {field.name for field in dataclasses.fields(mjbiped.RimlessWheel)} - shared
    for suffix in plot_style.SUFFIXES:
        assert options["plot"].type(f"walk{suffix}", options["plot"], None) == Path(f"walk{suffix}")
    model = mujoco.MjModel.from_xml_path(str(scene.models_folder() / "scene.xml"))
    assert {model.camera(index).name for index in range(model.ncam)} == set(cli_options.CAMERAS)
