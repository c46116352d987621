"""What a record must be to be loaded; whatever an engine records is, and records of all earlier formats."""

import dataclasses
import json
import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController, Controller, KneedController, PassiveController
from mjbiped.analysis.stability import stability
from mjbiped.plotting.walk import plot_walk
from mjbiped.records import measures
from mjbiped.records.columns import SAMPLES, TOUCHDOWNS
from mjbiped.records.record import Walk
from mjbiped.records.schema import ADDED, LONGEST_HEADER, parsed
from mjbiped.utils.domains import SEGMENTS


@pytest.fixture(scope="module")
def walk(controller: AdaptiveController) -> Walk:
    return mjbiped.walk(controller, mjbiped.Terrain.mixed(), engine="hybrid", steps=3)


class Parts:
    """What a record's file is made of."""

    def __init__(self, path: Path) -> None:
        with np.load(path) as file:
            self.arrays: dict[str, Any] = {name: file[name] for name in file.files}
        self.header = json.loads(str(self.arrays["header"]))

    @property
    def settings(self) -> Any:
        return self.header["settings"]

    def put(self, name: str, change: Callable[[np.ndarray], np.ndarray]) -> None:
        self.arrays[name] = change(self.arrays[name])


Change: TypeAlias = Callable[[Parts], Any]


def changed(walk: Walk, tmp_path: Path, change: Change) -> Path:
    """The file of a record after changes."""
    path = tmp_path / "walk.npz"
    walk.save(path)
    parts = Parts(path)
    change(parts)
    np.savez(path, **{**parts.arrays, "header": np.array(json.dumps(parts.header))})
    return path


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda r: r.header.update(outcome="flew"), "outcome is 'flew'; valid are finished, fell"),
        (lambda r: r.header.pop("outcome"), "outcome"),
        (lambda r: r.header.update(outcome="walking"), "outcome"),
        (lambda r: r.header.update(end=[0.0, math.nan]), "a time and a place"),
        (lambda r: r.header.update(end=[1.0]), "a time and a place"),
        (lambda r: r.header.update(version="1"), "version"),
        (lambda r: r.header.update(version=0), "version"),
        (lambda r: r.header.update(settings=[]), "expected a table"),
        (lambda r: r.settings.pop("robot"), "lack 'robot'"),
        (lambda r: r.settings["robot"].update(leg_mass=-1.0), "leg_mass"),
        (lambda r: r.settings["robot"].update(legs=3), "legs"),
        (lambda r: r.settings["terrain"].update(x=[1.0]), "terrain cannot be built"),
        (lambda r: r.settings.update(controller="x"), "a table with a name"),
        (lambda r: r.settings.update(initial=[0.0, 0.0, 0.0]), "4 numbers"),
        (lambda r: r.settings.update(warnings=3), "warnings"),
        (lambda r: r.settings.update(engine=None), "engine"),
        (lambda r: r.settings.update(warnings={"a": None}), "numbers of times"),
        (lambda r: r.settings.pop("scuffing"), "lack 'scuffing'"),
        (lambda r: r.settings.update(scuffing={"reach": "x"}), "scuffing rule cannot be built"),
        (lambda r: r.settings.update(scuffing={"legs": 2}), "scuffing rule cannot be built"),
        (lambda r: r.settings.update(disturbances=[1]), "disturbances cannot be built"),
        (lambda r: r.settings.update(disturbances={"control_period": None}), "not as they would have been written"),
        (lambda r: r.settings.update(controller_source=5), "a class and the digest"),
        (lambda r: r.settings.update(controller_source={"class": "a.py:B"}), "a class and the digest"),
        (lambda r: r.settings.update(more="x" * LONGEST_HEADER), "too long"),
        (lambda r: r.settings.update(initial=[10**400] * 4), "4 numbers"),
        (lambda r: r.settings.update(more="\ud800"), "surrogates"),
        (lambda r: r.put("samples/q", lambda column: column[:-1]), "samples/'q'.* rows of numbers"),
        (lambda r: r.put("samples/q", lambda column: column[:, :1]), r"samples/q .*floats of shape \(2,\) a row"),
        (lambda r: r.put("samples/stance", lambda column: column * 1.0), "expected whole numbers"),
        (lambda r: r.put("samples/stance", lambda column: column + 1), "other numbers than 0 and 1"),
        (lambda r: r.put("touchdowns/q", lambda column: column * math.nan), "touchdowns/q .*no finite number"),
        (lambda r: r.put("samples/qpos", lambda column: column * 1e12), "where no walk gets to"),
        (lambda r: r.put("samples/time", lambda column: column[::-1]), "do not ascend"),
        (lambda r: r.put("touchdowns/time", lambda column: column - 9.0), "do not ascend"),
        (lambda r: r.arrays.pop("samples/controller_states"), "controller_states"),
        (lambda r: r.arrays.update(peak_torque=np.zeros(3)), "peak_torque"),
        (lambda r: r.arrays.update({"samples/more": np.zeros(2)}), "samples/'more'.* rows of numbers"),
    ],
)  # fmt: skip
def test_what_is_not_promised_is_refused(walk: Walk, tmp_path: Path, change: Change, message: str) -> None:
    with pytest.raises(mjbiped.RecordError, match=message):
        Walk.load(changed(walk, tmp_path, change))


def test_headers_nested_without_end_are_refused(walk: Walk, tmp_path: Path) -> None:
    for levels in (60, 100_000):
        path = tmp_path / "walk.npz"
        walk.save(path)
        arrays = Parts(path).arrays
        text = str(arrays["header"]).replace('"settings": {', f'"settings": {{"a": {"[" * levels}{"]" * levels}, ')
        np.savez(path, **{**arrays, "header": np.array(text)})
        with pytest.raises(mjbiped.RecordError, match="no header of one"):
            Walk.load(path)


def test_settings_that_readers_only_show_may_be_anything(walk: Walk, tmp_path: Path) -> None:
    own = dataclasses.replace(walk, settings={**walk.settings, "engine": "mine", "tolerance": "tight", "steps": None})
    own.save(tmp_path / "walk.npz")
    assert Walk.load(tmp_path / "walk.npz") == own


@pytest.mark.slow
def test_the_longest_ground_fits_into_a_record(walk: Walk, tmp_path: Path) -> None:
    """Each of its numbers, and each segment as it was given."""
    rows = [[0.1 + 1e-9 * k, 0.1, 1e-5] for k in range(SEGMENTS.high)]
    ground = {"x": [row[0] * k for k, row in enumerate(rows)], "z": [0.0] * len(rows), "angle": [0.0] * len(rows)}
    settings = {"terrain": {**ground, "end": None, "name": "long", "parameters": [["segments", rows]]}}
    text = json.dumps({**walk.settings, **settings, "more": [-1.0 / 3.0] * 100_000})
    assert len(parsed(text)["terrain"]["x"]) == SEGMENTS.high


def test_further_columns_stay(walk: Walk, tmp_path: Path) -> None:
    more = np.arange(float(walk.steps))
    own = dataclasses.replace(walk, touchdowns={**walk.touchdowns, "clearance": more})
    own.save(tmp_path / "walk.npz")
    assert Walk.load(tmp_path / "walk.npz") == own


class Given(Controller):
    """Torques as they are given, from 0.1 s after each touchdown on."""

    states = ("state",)
    memory_size = 1

    def __init__(self, ankle: float, hip: float, rate: float = 0.0) -> None:
        self.values = (ankle, hip, rate)

    def torque(self, memory: Any, t: float, q: Any, dq: Any) -> Sequence[float]:
        if t < 0.1:
            return 0.0, 0.0, 0.0
        if self.values[0] == 42.0:
            raise ValueError("no torque")
        return self.values

    def slope_estimate(self, memory: Any) -> float:
        return math.inf


ODD = [(math.nan, 0.0), (0.0, math.inf), (1e9, -1e9), (0.0, 1e300), (3.0, 0.0, 1e200), (42.0, 0.0)]


@pytest.mark.parametrize("engine", ["mujoco", "hybrid"])
@pytest.mark.parametrize("values", ODD)
def test_whatever_an_engine_records_can_be_loaded_and_drawn(
    engine: str, values: tuple[float, ...], tmp_path: Path
) -> None:
    try:
        walk = mjbiped.walk(Given(*values), mjbiped.Terrain.incline(2.0), engine=engine, steps=2, sample_period=0.02)
    except mjbiped.WalkStopped as stop:
        walk = stop.walk
    walk.save(tmp_path / "walk.npz")
    again = Walk.load(tmp_path / "walk.npz")
    assert again == walk
    measures.summary(again)
    plot_walk(again)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["mujoco", "hybrid"])
def test_whatever_becomes_of_random_walks_can_be_loaded(
    engine: str, controller: AdaptiveController, tmp_path: Path
) -> None:
    draw = np.random.default_rng(5)
    path, outcomes = tmp_path / "walk.npz", []
    for case in range(100):
        sizes = 10.0 ** draw.uniform(-1.5, 1.0, size=5)
        names = ("leg_mass", "hip_mass", "lower_length", "upper_length", "gravity")
        robot = mjbiped.Compass(**dict(zip(names, sizes.tolist(), strict=True)))
        terrain = mjbiped.Terrain.random(seed=case, rise=(-0.1, 0.05))
        initial = [*draw.uniform(-1.0, 1.0, size=2), *(draw.uniform(-1.0, 1.0, size=2) * 10.0 ** draw.uniform(-1, 4))]
        law = PassiveController() if case % 2 else controller
        with suppress(mjbiped.InputError):  # a foot would start in the ground
            walk = mjbiped.walk(law, terrain, engine=engine, robot=robot, initial=initial, steps=3)
            walk.save(path)
            assert Walk.load(path) == walk
            outcomes.append(walk.outcome)
    assert len(outcomes) > 30
    assert len({*outcomes}) > 2


def test_finite_is_promised_of_motion_and_not_of_what_controllers_give() -> None:
    open_ones = [name for name, column in (*SAMPLES.items(), *TOUCHDOWNS.items()) if not column.finite]
    assert {"torque", "slope_estimate", "work_absolute"} <= {*open_ones}
    assert not {"time", "q", "dq", "qpos", "x", "z", "slope", "stance", "slip"} & {*open_ones}


# ---- what a sound record may still hold ------------------------------------------------------------------------------


def with_samples(walk: Walk, name: str, place: Any, value: float) -> Walk:
    column = walk.samples[name].copy()
    column[place] = value
    return dataclasses.replace(walk, samples={**walk.samples, name: column})


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("far", [-9e9, 3e5, 9e9])
def test_a_robot_far_away_is_drawn_in_a_figure_of_ordinary_size(walk: Walk, axis: int, far: float) -> None:
    figure = plot_walk(with_samples(walk, "qpos", (-1, axis), far))
    assert max(figure.get_size_inches()) < 40.0


def test_theorem_1_refuses_what_it_cannot_compute_with(walk: Walk) -> None:
    with pytest.raises(mjbiped.InputError, match="no finite number"):
        stability(with_samples(walk, "controller_states", 30, math.nan))
    with pytest.raises(mjbiped.InputError, match=r"no finite number|too great"):
        stability(with_samples(walk, "dq", 30, 1e300))
    for robot in ({"legs": 2}, None):
        controller = {**walk.settings["controller"], "robot": robot}
        odd = dataclasses.replace(walk, settings={**walk.settings, "controller": controller})
        with pytest.raises(mjbiped.InputError, match="cannot be built anew"):
            stability(odd)
        plot_walk(odd)


def test_a_touchdown_at_the_start_has_no_speed(walk: Walk) -> None:
    at_once = dataclasses.replace(walk, touchdowns={**walk.touchdowns, "time": walk.touchdowns["time"] * 0.0})
    assert math.isnan(measures.speed(at_once))
    assert measures.summary(at_once)["speed_m_per_s"] is None


Walks = dict[str, mjbiped.Walk]


@pytest.fixture(scope="module")
def walks(controller: AdaptiveController) -> Walks:
    robot, ground = mjbiped.KneedBiped(), mjbiped.Terrain.incline(2.0)
    law = KneedController(robot, mjbiped.find_kneed_gait(robot, math.radians(2.5)))
    return {
        "compass": mjbiped.walk(controller, ground, engine="hybrid", steps=2),
        "kneed": mjbiped.walk(law, ground, engine="hybrid", steps=2),
    }


@pytest.mark.parametrize("walker", ["compass", "kneed"])
@pytest.mark.parametrize("version", ADDED)
def test_a_record_of_a_version_is_read(version: int, walker: str, walks: Walks, tmp_path: Path) -> None:
    walk, path = walks[walker], tmp_path / "walk.npz"
    walk.save(path)
    later = {name for since, names in ADDED.items() if since > version for name in names}
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files if name not in later}
    arrays["header"] = np.array(json.dumps({**json.loads(str(arrays["header"])), "version": version}))
    np.savez(path, **arrays)
    old = mjbiped.Walk.load(path)
    for kind in ("samples", "touchdowns"):
        found, expected = getattr(old, kind), getattr(walk, kind)
        assert found.keys() == expected.keys()
        for name, column in expected.items():
            if f"{kind}/{name}" in later:
                assert found[name].shape == column.shape
                assert np.isnan(found[name]).all()
            else:
                assert found[name].tobytes() == column.tobytes()
    assert np.isnan(old.pressure_times).all() == (version < 4)
    assert (old.summary()["foot_length_99_percent_m"] is None) == (version < 4)
    assert old.summary()["cost_of_transport"] == walk.summary()["cost_of_transport"]


def test_a_record_that_lacks_what_its_version_has_is_refused(walks: Walks, tmp_path: Path) -> None:
    path = tmp_path / "walk.npz"
    walks["compass"].save(path)
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files if name != "touchdowns/contact_force"}
    np.savez(path, **arrays)
    with pytest.raises(mjbiped.RecordError, match="incomplete record: it lacks touchdowns/contact_force"):
        mjbiped.Walk.load(path)
