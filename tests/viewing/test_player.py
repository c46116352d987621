"""Time, keys and words of the viewer, without a screen."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import mjbiped
from controllers import AdaptiveController
from mjbiped.errors import RenderError
from mjbiped.rendering import ELEMENTS
from mjbiped.viewing import FASTEST, KEYS, SLOWEST, STRIDE, Player
from mjbiped.viewing import window as words
from mjbiped.viewing.sources import Replay


@pytest.fixture(scope="module")
def walk(controller: AdaptiveController) -> mjbiped.Walk:
    return mjbiped.walk(controller, mjbiped.Terrain.mixed(), steps=6, engine="hybrid")


@pytest.fixture
def player(walk: mjbiped.Walk) -> Player:
    return Player(Replay(walk))


def press(player: Player, *names: str) -> None:
    for name in names:
        player.press(KEYS[name].codes[-1])
    player.tick(0.0)


def test_no_key_does_two_things() -> None:
    codes = [code for key in KEYS.values() for code in key.codes]
    assert len(set(codes)) == len(codes)


@pytest.mark.slow
@given(
    frames=st.lists(st.floats(1e-3, 0.09), max_size=20),
    slower=st.integers(0, 3),
)
def test_time_runs_as_fast_as_asked_for(walk: mjbiped.Walk, frames: list[float], slower: int) -> None:
    player = Player(Replay(walk))
    press(player, *["slower"] * slower)
    for frame in frames:
        player.tick(frame)
    # the two sums are rounded differently
    assert player.source.time == pytest.approx(min(sum(frames) / 2**slower, walk.end[0]), abs=1e-12)


def test_a_frame_that_took_long_does_not_make_it_leap(player: Player) -> None:
    player.tick(30.0)
    assert player.source.time == pytest.approx(0.1)


def test_what_the_keys_do_to_a_record(player: Player, walk: mjbiped.Walk) -> None:
    times = walk.touchdowns["time"].tolist()
    press(player, "pause")
    player.tick(1.0)
    assert player.source.time == 0.0
    press(player, "next_touchdown", "next_touchdown")
    assert player.source.time == times[1]
    press(player, "back")
    assert player.source.time == pytest.approx(times[1] - STRIDE)
    press(player, "last_touchdown")
    assert player.source.time == times[0]
    press(player, "last_touchdown")
    assert player.source.time == 0.0
    press(player, *["forward"] * 3)
    assert player.source.time == pytest.approx(3 * STRIDE)
    press(player, *["next_touchdown"] * 10)
    assert player.source.ended == "finished"
    press(player, "restart")
    assert player.source.time == 0.0
    press(player, "next_seed")
    assert "random" in player.source.news
    press(player, "help")
    assert (player.source.news, player.helps) == ("", False)


def test_speeds_have_ends(player: Player) -> None:
    press(player, *["faster"] * 20)
    assert player.speed == FASTEST
    press(player, *["slower"] * 40)
    assert player.speed == SLOWEST


def test_other_keys_are_left_to_mujoco(player: Player) -> None:
    player.press(ord("F"))
    player.tick(0.01)
    assert not player.paused


def test_the_model_is_in_the_record_s_posture(player: Player, walk: mjbiped.Walk) -> None:
    press(player, *["next_touchdown"] * 3)
    player.source.show()
    assert player.source.data.qpos.tolist() == list(player.source.moment().qpos)
    # in the record both feet are on the ground at a touchdown, so MuJoCo finds contacts
    assert player.source.data.ncon >= 1


def test_words_are_in_the_characters_of_mujoco_s_font(player: Player, walk: mjbiped.Walk) -> None:
    player.tick(0.05)
    player.reached = 0.4
    for name, value in (words.state(player, player.source.moment(), ELEMENTS), words.keys()):
        assert (name + value).isascii()
        assert name.count("\n") == value.count("\n")
    assert "(reached 0.4 x)" in words.state(player, player.source.moment(), ELEMENTS)[1]
    press(player, "pause")
    assert "1 x (paused)" in words.state(player, player.source.moment(), ELEMENTS)[1]
    assert "torque" not in words.state(player, player.source.moment(), ())[0]
    press(player, *["next_touchdown"] * 10)
    assert words.news(player).startswith("finished")


def test_a_record_without_samples_is_refused(controller: AdaptiveController) -> None:
    walk = mjbiped.walk(controller, mjbiped.Terrain.mixed(), steps=2, engine="hybrid", sample_period=None)
    with pytest.raises(RenderError, match="no samples"):
        Replay(walk)


def test_the_speed_reached_is_measured(player: Player) -> None:
    assert math.isnan(player.reached)
    for _ in range(6):
        player.tick(0.2)  # of which a frame makes up for half
    assert player.reached == pytest.approx(0.5)
