"""Records of all earlier formats are read; numbers that their versions did not have are NaN."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController, KneedController
from mjbiped.records.schema import ADDED

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
