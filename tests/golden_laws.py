"""What every law answers in states about its gait: torques, estimates, discontinuities, and what it then remembers."""

from typing import Any

import numpy as np
from golden_walks import COMPARED

import mjbiped
from mjbiped.control.registry import make_controller
from mjbiped.robots.robot import Robot

NARROW: dict[str, Any] = {"sole": (0.12, 0.12), "sole_width": 0.08}
_DRIVEN: tuple[tuple[Robot, tuple[str, ...]], ...] = (
    (mjbiped.Compass(), ("adaptive", "supervised", "library", *COMPARED)),
    (mjbiped.Compass(4.0, 3.0, sole=(0.1, 0.08)), ("bounded-ankle", "supervised")),
    (mjbiped.FootedCompass(), ("bounded-ankle",)),
    (mjbiped.KneedBiped(), ("adaptive",)),
    (mjbiped.KneedBiped(sole=(0.1, 0.1)), ("bounded-ankle",)),
    (mjbiped.Compass3D(**NARROW), ("adaptive", "bounded-ankle")),
    (mjbiped.Kneed3D(), ("adaptive",)),
    (mjbiped.Abducting3D(**NARROW), ("bounded-ankle",)),
)
LAWS = {
    f"{name} of {robot.kind}{' on soles' * bool(robot.sole)}": (name, robot) for robot, laws in _DRIVEN for name in laws
}


def answers(name: str, robot: Robot) -> dict[str, list[float]]:
    """All that a law answers and remembers in two gait steps."""
    law, n, random = make_controller(name, robot, {}), len(robot.angles), np.random.default_rng(3)
    start = np.array(law.gait.start if law.gait else robot.after_touchdown(np.full(n, 0.1)))
    memory, found = [0.0] * law.memory_size, []

    def near(far: float) -> tuple[list[float], list[float]]:
        state = start + far * random.normal(size=2 * n)
        return state[:n].tolist(), state[n:].tolist()

    law.start(memory, *near(0.0))
    for far in (0.01, 0.1, 0.3):
        for t in (0.0, 0.02, 0.2, 0.6, 0.9):
            found += [*law.torque(memory, t, *near(far)), law.next_discontinuity(memory, t)]
            law.on_tick(memory, t, *near(far))
            found += [law.slope_estimate(memory), law.lateral_estimate(memory), *memory]
            if t == 0.6:
                law.on_knee_strike(memory, t, *near(far))
        law.on_touchdown(memory, near(far)[0], *near(far))
        found += memory
    return {"all": found}
