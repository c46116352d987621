"""The biped with knees in MuJoCo: its motors at touchdowns, stubs, faces, and steps that lead to gaps."""

import math
from typing import Any

import numpy as np
from simulations import started

import mjbiped
from controllers import PassiveController
from mjbiped.control.controller import Unpowered
from mjbiped.control.registry import make_controller
from mjbiped.engines.mujoco.step_size import Lengths, sooner
from mjbiped.rules.termination import Outcome

ROBOT = mjbiped.KneedBiped()


def walked(steps: int, terrain: mjbiped.Terrain | None = None, **settings: Any) -> mjbiped.Walk:
    engine = settings.pop("engine", mjbiped.Mujoco())
    ground = mjbiped.Terrain.incline(2.5) if terrain is None else terrain
    return mjbiped.walk(PassiveController(), ground, robot=ROBOT, engine=engine, steps=steps, **settings)


class Constant(Unpowered):
    """Torques too small to matter."""

    def torque(self, memory: Any, t: float, q: Any, dq: Any) -> tuple[float, float, float]:
        return 1e-6, 2e-6, 1e-7


def test_what_waits_goes_to_the_motor_that_it_was_meant_for() -> None:
    """The hip's torque acts after the touchdown with the other sign; the knee that it was for is locked by then."""
    samples, end, touched, _ = constant(control_period=0.005, delay=0.1)
    time, (hip, knee) = samples["time"], samples["torque"][:, 1:].T
    before, after = (time > touched - 0.08) & (time < touched - 1e-9), (time > touched) & (time < touched + 0.09)
    later = (time > touched + 0.106) & (time < end - 1e-9) & (samples["locked"] == 0)
    assert (hip[before] == 2e-6).all()
    assert (hip[after] == -2e-6).all()
    assert not knee[before | after].any()  # it is locked
    assert (hip[later] == 2e-6).all()
    assert (knee[later] == 1e-7).all()


def constant(**disturbances: Any) -> tuple[Any, float, float, float]:
    """Samples of two steps under constant torques, their end, the first touchdown, and the tick behind it, s."""
    loop = mjbiped.Disturbances(**disturbances)
    start = mjbiped.find_kneed_gait(ROBOT, math.radians(2.5)).start
    found = mjbiped.walk(
        Constant(),
        mjbiped.Terrain.incline(2.5),
        robot=ROBOT,
        initial=start.tolist(),
        steps=2,
        sample_period=1e-3,
        disturbances=loop,
    )
    first, last = found.touchdowns["time"]
    period = disturbances["control_period"]
    return found.samples, last, first, period * math.ceil(first / period)


def test_a_stubbed_toe_is_physics() -> None:
    """A riser in the swing foot's way stops it; it slides down the face, takes over there, and is stopped as it stands.

    Without motors the robot falls; nothing passes through the step.
    """
    ground = mjbiped.Terrain.from_segments([(0.7, 2.5, 0.0), (20.0, 2.5, 0.035)])
    found = walked(3, ground)
    assert (found.outcome, found.steps) == ("fell", 2)
    assert found.touchdowns["strikes"][1] == 1
    feet = ROBOT.limbs(found.samples["qpos"])[:, :, -1]
    inside = ground.height(feet[..., 0]) - feet[..., 1]
    # but the last 1e-3 m beside its face, where a foot is on the lower ground
    edge = np.abs(feet[..., 0] - ground.x[1]) < 2e-3
    assert inside[~edge].max() < 1e-4


def test_a_foot_that_slides_down_a_face_does_so_in_sixteenths_of_a_step() -> None:
    """Contact steps lead it to the face; in such steps alone, the way down would take six thousand of them."""
    controller = make_controller("adaptive", ROBOT, {})
    simulation = started(controller, mjbiped.Terrain.stairs(tread=1.2, rise=0.02), steps=8)
    lengths = []
    while not simulation.over:
        simulation.advance(1)
        lengths.append(simulation.model.opt.timestep)
    assert simulation.outcome is Outcome.FINISHED
    assert np.isclose(lengths, 1e-3 / 16.0).sum() > 500
    assert np.isclose(lengths, 1e-5).sum() < 2000


def test_friction_is_the_feets() -> None:
    assert walked(2, disturbances=mjbiped.Disturbances(friction=0.05)).outcome == "slipped"


def test_a_gap_that_stays_open_cuts_no_step_short_that_closes_the_other() -> None:
    """A step may end half as long again as planned: rounding decides, and a touchdown was lost, one in hundreds."""
    closing, open_still = Lengths(1.0000008e-5, 1e-5, True), Lengths(1e-5, 1e-3, False)
    assert sooner(closing, open_still, 1e-5) == sooner(open_still, closing, 1e-5) == closing
    ending = Lengths(4e-6, 1e-5, False)  # but one that needs a shorter step has it
    assert sooner(closing, ending, 1e-5) == sooner(ending, closing, 1e-5) == ending
