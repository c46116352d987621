"""Trained policies as controllers, which observe in `mjbiped.walk` what they observed in their environment."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjbiped.control.controller import Controller, Memory
from mjbiped.disturbances.chance import MOST
from mjbiped.envs.driven import DrivenController
from mjbiped.envs.observation import AFTER, BEFORE, bounds, observe
from mjbiped.envs.tasks import WalkTask
from mjbiped.errors import InputError, explained, prefixed, shown
from mjbiped.robots.kinds import robot_from
from mjbiped.utils.files import read_bytes, saved
from mjbiped.utils.packages import needed

Predict = Callable[[NDArray[np.float64]], ArrayLike]
"""An action, shares of the greatest torques from -1 to 1, of an observation."""

_TASK = "mjbiped"
"""Entry of an ONNX file's metadata that describes the policy's task."""

LEFT, TOUCHED, LOCKED, HELD = range(4)
"""Indices in a policy's part of the memory: ticks until the next action, whether the swing foot has touched down since
the last one, and the swing knee is locked; then the torques held (N m), and the angles at the last touchdown in the old
roles and in the new ones (rad)."""


class ActingController(Controller):
    """Walks by a policy, which acts once in each control period of its task.

    Attributes:
        task: The task for which the policy was trained.
        predict: The policy.
    """

    task: WalkTask
    predict: Any

    def _take(self, task: WalkTask) -> None:
        """Take over joints, robot, gait and the period of ticks from the task.

        Raises:
            InputError: The policy observes the ground, which no controller sees.
        """
        if task.privileged:
            raise InputError(
                "a policy of a privileged task observes the ground, which no controller sees; train it blind"
            )
        driven = task.controller
        for name, value in {
            "task": task,
            **{name: getattr(driven, name) for name in ("states", "joints", "support", "robot")},
            "gait": task.gait,
            "memory_size": driven.memory_size + HELD + 3 * len(driven.joints),
            "control_period": task.engine.control_period,
        }.items():
            object.__setattr__(self, name, value)

    @property
    def _driven(self) -> DrivenController:
        return self.task.controller

    def start(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        """Begin as the controller does to which actions are added."""
        self._driven.start(memory, q, dq)

    def on_touchdown(self, memory: Memory, q_before: Sequence[float], q: Sequence[float], dq: Sequence[float]) -> None:
        """Remember the touchdown; until the next tick the motors that drive other joints now are off."""
        self._driven.on_touchdown(memory, q_before, q, dq)
        at, n = self._driven.memory_size, len(q)
        memory[at + TOUCHED], memory[at + LOCKED] = 1.0, 0.0
        held = [0.0] * n
        held[1] = -memory[at + HELD + 1]
        memory[at + HELD : at + HELD + 3 * n] = [*held, *q_before, *q]

    def on_knee_strike(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> None:
        """Remember that the swing knee is locked, and its motor off."""
        self._driven.on_knee_strike(memory, t, q, dq)
        at = self._driven.memory_size
        memory[at + LOCKED], memory[at + HELD + 2] = 1.0, 0.0

    def on_tick(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> None:
        """Ask the policy for an action when one is due, and remember the torques that are held from now on.

        Raises:
            InputError: The policy gives something else than an action.
        """
        driven, at, n = self._driven, self._driven.memory_size, len(q)
        memory[at + LEFT] -= 1.0
        if memory[at + LEFT] <= 0.0:
            memory[driven.place : at] = self.action(memory, t, q, dq)
            memory[at + LEFT], memory[at + TOUCHED] = float(self.task.ticks), 0.0
        memory[at + HELD : at + HELD + n] = driven.torque(memory, t, q, dq)[:n]
        if memory[at + LOCKED]:
            memory[at + HELD + 2] = 0.0

    def observation(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> NDArray[np.float64]:
        """What the policy observes at a tick, as in its environment; see `mjbiped.envs.observation.FIELDS`."""
        at, n = self._driven.memory_size, len(q)
        held, before, after = (memory[at + HELD + k * n : at + HELD + (k + 1) * n] for k in range(3))
        readings = [0.0] * (5 * MOST)
        for first, values in zip((0, MOST, BEFORE, AFTER), (q, dq, before, after), strict=True):
            readings[first : first + n] = values
        seen = [0.0] * len(bounds(n)[0])
        observe(seen, n, readings, held, t, bool(memory[at + TOUCHED]), memory[at + LOCKED])
        return np.array(seen)

    def action(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> list[float]:
        """Torques of the policy's action, N m; see `Controller.on_tick` for the arguments.

        Raises:
            InputError: The policy gives something else.
        """
        seen, most = self.observation(memory, t, q, dq), np.array(self.task.limits)
        given = self.predict(seen)
        try:
            torques: list[float] = (np.asarray(given, dtype=np.float64).reshape(most.shape) * most).tolist()
            return torques
        except (TypeError, ValueError) as error:
            raise InputError(
                f"the policy gives {shown(given)} for an observation of {len(seen)} numbers; expected {len(most)} "
                f"numbers from -1 to 1: {', '.join(self.joints)}"
            ) from error

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        """Torques with the present action, and the rates of states; see `Controller.torque`."""
        return self._driven.torque(memory, t, q, dq)

    def slope_estimate(self, memory: Memory) -> float:
        """Estimate of the adaptive controller where actions are added to its torques, else NaN, rad."""
        return self._driven.slope_estimate(memory)


@dataclass(frozen=True)
class PolicyController(ActingController):
    """Walks by any function from observations to actions: a policy that was trained in an environment, for instance.

    ```python
    task = mjbiped.envs.WalkTask("walk_random", residual=True)
    controller = mjbiped.envs.PolicyController(lambda seen: model.predict(seen, deterministic=True)[0], task)
    walk = mjbiped.walk(controller, mjbiped.Terrain.random(seed=5), engine=task.engine)
    ```

    In MuJoCo with the task's engine the walk is bitwise that of an episode. Where soles limit the ankle's torque,
    or motors lag, the torques observed are those commanded.

    Attributes:
        predict: The policy: an observation, shape (numbers,), to an action from -1 to 1, shape (joints,). It depends
            on nothing else, so that a walk can be repeated.
        task: The task for which it was trained; terrain and time limit do not matter.

    Raises:
        InputError: The task is privileged.
    """

    predict: Predict
    task: WalkTask

    def __post_init__(self) -> None:
        """Take over what the task says."""
        self._take(self.task)

    def describe(self) -> dict[str, object]:
        """Name, the function's name and the task; a record cannot build the function anew."""
        policy = getattr(self.predict, "__qualname__", type(self.predict).__name__)
        return {"name": f"envs.{type(self).__name__}", "policy": policy, "task": _described(self.task)}


@dataclass(frozen=True)
class OnnxController(ActingController):
    """Walks by a policy in an ONNX file that `export_policy` wrote; on the command line `--controller policy:FILE`.

    Attributes:
        file: The file.
        sha256: Digest that the file must have; empty: any. Records have it.

    Raises:
        InputError: There is no such file, it is no such policy or another one, or ONNX Runtime is not installed.
    """

    file: str
    sha256: str = ""

    task: WalkTask = field(init=False, repr=False, compare=False)
    _session: Any = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Read the file."""
        with prefixed(f"the policy's file {shown(self.file)}: "):
            content = read_bytes(Path(self.file).expanduser())
        digest = hashlib.sha256(content).hexdigest()
        if self.sha256 not in ("", digest):
            raise InputError(f"{self.file} is another policy than the one recorded: its SHA-256 is {digest}")
        runtime = needed("onnxruntime", "onnx", "a policy in a file")
        options = runtime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1  # the same bits each time
        try:
            session = runtime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
        except Exception as error:  # of the runtime's own kinds
            raise InputError(f"{self.file} is no ONNX file: {explained(error)}") from error
        object.__setattr__(self, "sha256", digest)
        object.__setattr__(self, "_session", session)
        described = session.get_modelmeta().custom_metadata_map.get(_TASK)
        if described is None:
            raise InputError(
                f"{self.file} does not say for which task its policy was trained; mjbiped.envs.export_policy writes "
                "that, and mjbiped.envs.PolicyController takes any function"
            )
        try:
            settings = json.loads(described)
            task = WalkTask(**{**settings, "robot": robot_from(settings["robot"])})
        except (InputError, KeyError, TypeError, ValueError) as error:
            raise InputError(
                f"{self.file} describes its policy's task in a way that this mjbiped cannot read: {explained(error)}; "
                "write it again with mjbiped.envs.export_policy"
            ) from error
        self._take(task)
        numbers, wanted = session.get_inputs()[0].shape[-1], len(bounds(len(self.joints))[0])
        if numbers != wanted:
            raise InputError(f"{self.file}: the policy observes {numbers} numbers; its task has {wanted}")

    def describe(self) -> dict[str, object]:
        """Name, file and its digest, from which the controller is built anew."""
        return {"name": type(self).__name__, "file": self.file, "sha256": self.sha256}

    def predict(self, seen: NDArray[np.float64]) -> NDArray[np.float32]:
        """The action of an observation."""
        action: NDArray[np.float32] = self._session.run(None, {"observation": seen[None].astype(np.float32)})[0][0]
        return action

    def __reduce__(self) -> tuple[object, ...]:
        """Return what reads the file again: the runtime's session cannot be copied."""
        return type(self), (self.file, self.sha256)


def _described(task: WalkTask) -> dict[str, object]:
    """What a policy as a controller needs to know of its task, as settings of `WalkTask` in plain JSON types."""
    return {
        "name": task.name,
        "residual": task.residual,
        "control_period": task.control_period,
        "robot": task.model.to_dict(),
        "disturbances": {"control_period": task.engine.control_period},
    }


def export_policy(model: Any, path: str | Path, task: WalkTask, normalisation: Any = None) -> None:
    """Write the deterministic policy of a stable-baselines3 model as an ONNX file, by which `policy:FILE` walks.

    Args:
        model: The trained model, of any algorithm with continuous actions.
        path: The file; it appears whole or not at all.
        task: The task for which it was trained, `robots.task` of a `WalkVecEnv`.
        normalisation: The `VecNormalize` that normalised observations in the training; None: none did.

    Raises:
        InputError: onnx or PyTorch is not installed, or the policy is for other robots or privileged tasks.
        RecordError: The file cannot be written.
    """
    onnx, torch = needed("onnx", "onnx", "the export of a policy"), needed("torch", "sb3", "the export of a policy")
    numbers = len(bounds(len(task.limits))[0])
    if model.observation_space.shape != (numbers,):
        raise InputError(
            f"the policy observes {model.observation_space.shape[0]} numbers, and in the task, without a view of the "
            f"ground, there are {numbers}"
        )
    mean, scale, most = np.zeros(numbers), np.ones(numbers), np.inf
    if normalisation is not None and normalisation.norm_obs:
        mean, most = normalisation.obs_rms.mean, normalisation.clip_obs
        scale = 1.0 / np.sqrt(normalisation.obs_rms.var + normalisation.epsilon)
    shift, factor = (torch.tensor(each, dtype=torch.float32) for each in (mean, scale))

    class Policy(torch.nn.Module):  # type: ignore[misc, name-defined]  # an extra, without types
        def __init__(self) -> None:
            super().__init__()
            self.policy = model.policy

        def forward(self, observation: Any) -> Any:
            return self.policy._predict(((observation - shift) * factor).clip(-most, most), deterministic=True)

    with saved(Path(path)) as unfinished:
        names = {"input_names": ["observation"], "output_names": ["action"]}
        torch.onnx.export(Policy().eval().cpu(), (torch.zeros(1, numbers),), str(unfinished), **names, dynamo=False)
        graph = onnx.load(str(unfinished))
        onnx.helper.set_model_props(graph, {_TASK: json.dumps(_described(task))})
        onnx.save(graph, str(unfinished))
