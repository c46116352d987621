"""Passive walks by diffrax: the same equations in JAX, in 64 bits, a whole walk compiled as one function.

Optional: `pip install diffrax 'jax[cpu]'`. Equations of motion and impact map are the functions of
`mjbiped.robots.compass`, with JAX's sine and cosine. A gait step ends by diffrax's event, which Newton's method finds
on the dense output of its last integration step.
"""

from __future__ import annotations

import math
import os
from types import FunctionType
from typing import Any

os.environ.setdefault("JAX_PLATFORMS", "cpu")
os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1")

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import optimistix
from numpy.typing import NDArray

from mjbiped.robots import compass
from mjbiped.robots.compass import Compass

jax.config.update("jax_enable_x64", True)
LONGEST = 3.0  # s, of a gait step
MOST_STEPS = 4096  # of the integrator in one

_laws: dict[str, Any] = {**vars(compass), "math": jnp}
_laws |= {
    name: FunctionType(law.__code__, _laws) for name, law in vars(compass).items() if isinstance(law, FunctionType)
}


class DiffraxWalk:
    """A passive walk on a plane."""

    def __init__(self, robot: Compass, slope: float, *, tolerance: float, steps: int) -> None:
        """Trace the walk; it is compiled at its first call.

        Args:
            robot: Who walks.
            slope: Of the plane, rad.
            tolerance: rtol and atol of the step size controller.
            steps: Gait steps.
        """
        solver, control = diffrax.Dopri8(), diffrax.PIDController(rtol=tolerance, atol=tolerance)
        event = diffrax.Event(_clearance, optimistix.Newton(rtol=1e-10, atol=1e-10), direction=False)
        constants, sine, cosine = robot.constants, math.sin(slope), math.cos(slope)

        def rates(_: Any, state: Any, __: Any) -> Any:
            q1, q2, dq1, dq2 = state
            return jnp.stack([dq1, dq2, *_laws["acceleration"](constants, q1, q2, dq1, dq2, sine, cosine, 0.0, 0.0)])

        first = 0.2 * math.sqrt(robot.leg_length / robot.gravity)

        def gait_step(state: Any, _: Any) -> tuple[Any, Any]:
            solution = diffrax.diffeqsolve(
                diffrax.ODETerm(rates),
                solver,
                0.0,
                LONGEST,
                first,
                state,
                stepsize_controller=control,
                event=event,
                max_steps=MOST_STEPS,
                adjoint=diffrax.ForwardMode(),
                throw=False,
            )
            q1, q2, dq1, dq2 = solution.ys[-1]
            after = jnp.stack([q2, q1, *_laws["impact_rates"](constants, q1, q2, dq1, dq2)])
            return after, after

        self._walk = jax.jit(lambda start: jax.lax.scan(gait_step, start, length=steps)[1])

    def states(self, start: NDArray[np.float64]) -> NDArray[np.float64]:
        """State (rad, rad/s) after each touchdown, shape (steps, 4), from q1, q2, dq1, dq2 at the start.

        Where diffrax misses a touchdown, what follows is no walk: it is not asked to tell, for that takes time.
        """
        return np.asarray(self._walk(jnp.asarray(start)).block_until_ready())


def _clearance(t: Any, y: Any, args: Any, **_: Any) -> Any:  # noqa: ARG001 (diffrax names them)
    """Drake's: on a plane the swing foot, once ahead, is above the ground where this is positive; no foot scuffs."""
    q1, q2, _dq1, _dq2 = y
    return jnp.maximum(-q1 - q2, q2 - q1)
