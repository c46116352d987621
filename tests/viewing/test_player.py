"""Time, keys and words of the viewer, without a screen."""

import pytest

import mjbiped
from mjbiped.rendering import ELEMENTS
from mjbiped.viewing import FASTEST, KEYS, SLOWEST, STRIDE, Player
from mjbiped.viewing import window as words
from mjbiped.viewing.sources import Replay


@pytest.fixture
def player(walk: mjbiped.Walk) -> Player:
    return Player(Replay(walk))


def press(player: Player, *names: str) -> None:
    for name in names:
        player.press(KEYS[name].codes[-1])
    player.tick(0.0)


def test_no_key_does_two_things_and_others_are_left_to_mujoco(player: Player) -> None:
    codes = [code for key in KEYS.values() for code in key.codes]
    assert len(set(codes)) == len(codes)
    player.press(ord("F"))
    player.tick(0.01)
    assert not player.paused


@pytest.mark.parametrize("slower", range(4))
def test_time_runs_as_fast_as_asked_for(player: Player, walk: mjbiped.Walk, slower: int) -> None:
    press(player, *["slower"] * slower)
    elapsed = [0.001, 0.09, 30.0, 0.05] * 30  # of a frame that took long, 0.1 s is made up for
    for frame in elapsed:
        player.tick(frame)
    # the two sums are rounded differently
    expected = min(sum(min(frame, 0.1) for frame in elapsed) / 2**slower, walk.end[0])
    assert player.source.time == pytest.approx(expected, abs=1e-12)
    press(player, *["faster"] * 20)
    assert player.speed == FASTEST
    press(player, *["slower"] * 40)
    assert player.speed == SLOWEST


def test_what_the_keys_do_to_a_record(player: Player, walk: mjbiped.Walk) -> None:
    times = walk.touchdowns["time"].tolist()
    press(player, "pause")
    player.tick(1.0)
    assert player.source.time == 0.0
    for keys, time in (
        (["next_touchdown"] * 2, times[1]),
        (["back"], times[1] - STRIDE),
        (["last_touchdown"], times[0]),
        (["last_touchdown"], 0.0),
        (["forward"] * 3, 3 * STRIDE),
        (["next_touchdown"] * 10, walk.end[0]),
        (["restart"], 0.0),
    ):
        press(player, *keys)
        assert player.source.time == pytest.approx(time, abs=1e-15)
    press(player, "next_touchdown", "pause")
    player.tick(0.05)
    assert player.source.time == pytest.approx(times[0] + 0.05)  # it goes on from there
    press(player, "next_seed")
    assert "random" in player.source.news


def test_the_model_is_in_the_record_s_posture(player: Player) -> None:
    press(player, *["next_touchdown"] * 3)
    player.source.show()
    assert player.source.data.qpos.tolist() == list(player.source.moment().qpos)
    # in the record both feet are on the ground at a touchdown, so MuJoCo finds contacts
    assert player.source.data.ncon >= 1


def test_words_tell_the_state_and_the_end(player: Player) -> None:
    for _ in range(6):
        player.tick(0.2)  # of which a frame makes up for half
    assert "(reached 0.5 x)" in words.state(player, player.source.moment(), ())[1]
    press(player, "pause")
    names, values = words.state(player, player.source.moment(), ELEMENTS)
    assert (names + values).isascii()
    assert (names.count("\n"), "(paused)" in values) == (values.count("\n"), True)
    press(player, *["next_touchdown"] * 10)
    assert words.news(player).startswith("finished")
