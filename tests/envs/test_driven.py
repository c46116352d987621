"""The controller that is told what to add: its law and its methods say the same, and its base goes on undisturbed."""

import math
import pickle

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController, Controller, PassiveController
from mjbiped.control.compiled import as_machine_code, compilable_law
from mjbiped.control.functions import law_of
from mjbiped.envs.driven import DrivenController

MOST, PEAK = (3.0, 2.0), (10.0, 5.0)


def driven(base: Controller) -> DrivenController:
    return DrivenController(base, MOST, PEAK)


def test_it_has_what_its_base_has(controller: AdaptiveController) -> None:
    own = driven(controller)
    assert own.states == controller.states
    assert own.memory_size == controller.memory_size + 2
    assert own.robot is controller.robot
    assert own.gait is controller.gait
    assert law_of(own) is not None
    assert own.describe()["base"] == controller.describe()


@pytest.mark.parametrize("added", [(0.0, 0.0), (1.0, -0.5), (100.0, -100.0)])
def test_what_is_added_is_cut_off_and_so_is_the_sum(controller: AdaptiveController, added: tuple[float, float]) -> None:
    own, memory = driven(controller), [0.0] * (controller.memory_size + 2)
    q, dq = (-0.15, 0.3), (1.5, 2.0)
    own.start(memory, q, dq)
    memory[-2:] = added
    plain = controller.torque(memory, 0.1, q, dq)
    values = own.torque(memory, 0.1, q, dq)
    for got, base, more, most, peak in zip(values, plain, added, MOST, PEAK, strict=False):
        assert got == min(max(base + min(max(more, -most), most), -peak), peak)
    assert tuple(values[2:]) == tuple(plain[2:])


def test_nothing_added_within_the_limits_is_bitwise_the_base(controller: AdaptiveController) -> None:
    strong = DrivenController(controller, MOST, (100.0, 100.0))
    alone, within = (
        mjbiped.walk(each, mjbiped.Terrain.mixed(), steps=8, sample_period=None) for each in (controller, strong)
    )
    for name, column in alone.touchdowns.items():
        np.testing.assert_array_equal(column, within.touchdowns[name], err_msg=name)


class Plain(PassiveController):
    """Without laws to be compiled."""

    def torque(self, memory, t, q, dq):  # type: ignore[no-untyped-def]
        return 0.1, 0.2


def test_a_base_in_plain_python_makes_it_plain_python() -> None:
    assert compilable_law(driven(Plain())) is None
    assert tuple(driven(Plain()).torque([0.5, 0.0], 0.0, (0.0, 0.0), (0.0, 0.0))) == (0.6, 0.2)


def test_it_can_be_pickled_after_it_was_compiled(controller: AdaptiveController) -> None:
    own = driven(controller)
    assert not as_machine_code(own).failed
    again = pickle.loads(pickle.dumps(own))
    assert again.describe() == own.describe()
    assert again.memory_size == own.memory_size
    assert compilable_law(again) is not None


def test_no_number_stays_none(controller: AdaptiveController) -> None:
    memory = [0.0] * (controller.memory_size + 2)
    memory[-2] = math.nan
    assert math.isnan(driven(PassiveController()).torque([math.nan, 0.0], 0.0, (0.0, 0.0), (0.0, 0.0))[0])
