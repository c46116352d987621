"""`mjbiped gait`, `reference`, `stability`, `return-map`, `bifurcation`, `basin`: what they print and write."""

import json
import math
import re
from concurrent.futures import as_completed
from pathlib import Path
from typing import Any

import numpy as np
import own_controllers
import pytest
from command_line import Drawings, ran, run

import mjbiped
from mjbiped.analysis.stability import stability
from mjbiped.limit_cycles import basin
from mjbiped.limit_cycles.basin import Fate

SMALL = ("--slopes", 24, "--steps", 60, "--keep", 12, "--doublings", 2)


def printed(*words: object) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(ran(*words, "--json"))
    return found


def test_gait_prints_the_cycle(drawings: Drawings, tmp_path: Path) -> None:
    plot = tmp_path / "gait.pdf"
    text = ran("gait", "--slope-deg", 2, "--plot", plot)
    assert re.search(r"period +0\.76484357 +s\s", text)
    assert re.search(r"stable +yes", text)
    assert text.endswith(f"wrote {plot}\n")
    assert drawings == [("gait", mjbiped.find_passive_gait(mjbiped.Compass(), math.radians(2)), {})]


def test_gait_as_json_is_the_gait() -> None:
    found = printed("gait", "--slope-deg", 3.6, "--hip-mass", 5)
    gait = mjbiped.find_passive_gait(mjbiped.Compass(hip_mass=5.0), math.radians(3.6))
    assert (found["state_after_impact"], found["state_before_impact"]) == (gait.start.tolist(), gait.end.tolist())
    assert (found["period_s"], found["step_length_m"]) == (gait.period, gait.step_length)
    assert (found["speed_m_per_s"], found["energy_J"], found["stable"]) == (gait.speed, gait.energy, gait.stable)
    assert [each["modulus"] for each in found["multipliers"]] == pytest.approx(abs(gait.multipliers))
    found = printed("gait", "--robot", "halved-rods", "--slope-deg", 5.5)
    kneed = mjbiped.find_kneed_gait(mjbiped.KneedBiped.halved_rods(), math.radians(5.5))
    assert found["state_after_heel_strike"] == kneed.start.tolist()
    assert (found["knee_strike_s"], found["clearance_m"]) == (kneed.knee_strike, kneed.clearance)


KNEED = pytest.param(("--robot", "kneed"), mjbiped.KneedBiped(), marks=pytest.mark.slow)


@pytest.mark.parametrize(("words", "robot"), [((), mjbiped.Compass()), KNEED])
def test_reference_is_the_gait(words: tuple[str, ...], robot: mjbiped.Compass, tmp_path: Path) -> None:
    plot = tmp_path / "reference.png"
    found = printed("reference", *words, "--clearance", "0", "--plot", plot)
    gait = mjbiped.find_reference(robot, clearance=0.0)
    assert found["cost_of_transport"] == gait.cost_of_transport
    assert (found["period_s"], found["half_angle_rad"], found["clearance_m"]) == (gait.period, gait.end[0], None)
    for k, joint in enumerate(robot.joints):
        assert found[f"peak_{joint}_torque_Nm"] == gait.measures.peak_torque[k]
    assert found.get("knee_strike_s") == (pytest.approx(0.88 * gait.period) if words else None)
    assert plot.read_bytes().startswith(b"\x89PNG")


def test_stability_tells_theorem_1(record: Path, tmp_path: Path) -> None:
    plot = tmp_path / "stability.png"
    found = printed("stability", record, "--plot", plot)
    assert plot.stat().st_size > 10_000
    theorem = stability(mjbiped.Walk.load(record))
    assert found["condition_24_smallest_for_any_constants"] == theorem.condition_floor.min() > 1.0
    assert (found["condition_24_holds_steps"], found["errors_26_holds_steps"], found["steps"]) == (0, 1, 2)
    assert found["error_before_last_touchdown"] == pytest.approx(np.linalg.norm(theorem.end[-1]))
    assert found["residual_largest"] == theorem.residual.max()


def test_return_map_tells_the_gait_and_writes_its_files(tmp_path: Path) -> None:
    paths = [tmp_path / name for name in ("map.npz", "map.png")]
    text = ran("return-map", "--slope-deg", 3, "--points", 40, "--out", paths[0], "--plot", paths[1])
    assert all(each in text for each in ("angle of the stance leg (rad)", "multipliers", *map(str, paths)))
    with np.load(paths[0]) as data:
        assert data["before"].shape == data["after"].shape == (3, 40)
        assert data["walk"].shape == (41, 3)
    assert paths[1].stat().st_size > 10_000
    found = printed("return-map", "--robot", "wheel", "--slope-deg", 5)
    assert found["fixed_point"] == {"rate of the stance spoke (rad/s)": pytest.approx(1.144017, abs=1e-6)}
    assert (found["multipliers"], found["settled_period"]) == ([[pytest.approx(0.5), 0.0]], 1)


@pytest.mark.slow
def test_bifurcation_tells_the_onsets_and_writes_its_files(tmp_path: Path) -> None:
    paths = [tmp_path / name for name in ("data.npz", "diagram.png", "multipliers.pdf")]
    words = ("--out", paths[0], "--plot", paths[1], "--plot-multipliers", paths[2])
    # on 3.6 degrees only three of four starts are lost within 60 steps, and rounding decides which; on 3.7 all are
    text = ran("bifurcation", *SMALL, *words, "--slope-deg", "2.4..3.7").replace("\n", "")
    assert all(each in text for each in ("2.72844", "3.2986", "lost", *map(str, paths)))
    with np.load(paths[0]) as data:
        assert data["states"].shape == (len(data["slopes"]), 12, 4)
        assert np.degrees(data["onsets"]) == pytest.approx([2.72844, 3.29863], abs=1e-5)
    assert min(path.stat().st_size for path in paths[1:]) > 5_000
    # from before the first doubling to beyond the first fall, without being told where they are
    found = printed("bifurcation", "--robot", "kneed", "--sole", 0.1, *SMALL)
    assert found["onsets_deg"] == pytest.approx([5.683, 6.2126], abs=1e-3)
    assert 6.5 < found["lost_deg"] < 6.7


def test_basin_tells_the_shares_and_writes_its_files(tmp_path: Path) -> None:
    paths = [tmp_path / name for name in ("data.npz", "basin.png")]
    text = ran("basin", "--grid", 6, "--out", paths[0], "--plot", paths[1], "--threads", 1).replace("\n", "")
    assert all(each in text for each in ("settled", "fell", "36", *map(str, paths)))
    with np.load(paths[0]) as data:
        assert data["fates"].shape == data["steps"].shape == (6, 6)
        assert data["fate_names"][0] == "settled"
        gait = mjbiped.find_passive_gait(mjbiped.Compass(), math.radians(2))
        for name, rate in (("stance_rates", gait.start[2]), ("swing_rates", gait.start[3])):
            assert data[name][0] < rate < data[name][-1]
        settled = (data["fates"] == Fate.SETTLED).mean()
    words = ("--stance-rates", "0..2", "--swing-rates=-1..1", "--grid", 3)
    found = printed("basin", "--controller", "adaptive", *words)
    assert (found["walker"], found["slope_deg"], found["starts"]) == ("AdaptiveController", 0.0, 9)
    assert found["shares"]["settled"] == 1.0
    assert 0.0 < settled < 1.0


def test_an_interrupted_basin_and_one_that_fails_are_written(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a class of the user's own, which gets robot and gait."""
    above = "import mjbiped\nfrom dataclasses import dataclass\n@dataclass(frozen=True)"
    fields = "robot: mjbiped.Compass\ngait: mjbiped.Gait"
    body = "if t > 0.1:\n    raise KeyError('gone')\nreturn 0.0, 0.0"
    own_controllers.write(folder, "failing.py", own_controllers.law(body, above=above, fields=fields))
    words = ("basin", "--out", "basin.npz", "--quiet", "--threads", 1)
    result = run(*words, "--controller", "failing.py:Law", "--grid", 2)
    assert (result.exit_code, Path("basin.npz").is_file()) == (1, True)
    assert "Law failed in the walk from the rates" in result.stderr

    def interrupted(futures: list[object]) -> object:
        next(as_completed(futures))  # type: ignore[arg-type,var-annotated,unused-ignore]
        raise KeyboardInterrupt
        yield

    monkeypatch.setattr(basin, "as_completed", interrupted)
    result = run(*words, "--grid", 200)
    assert (result.exit_code, "interrupted" in result.stderr) == (130, True)
    with np.load("basin.npz") as data:
        assert 0 < (data["fates"] != Fate.UNDECIDED).any(axis=1).sum() < 200
