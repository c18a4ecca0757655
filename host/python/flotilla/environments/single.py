"""Gymnasium: one structure, one agent for all of its modules."""

from typing import Any

import gymnasium
import numpy as np

from . import _core
from ._core import Action, Contact, Fidelity, Floats, Options, Planner, Task


class FlotillaEnv(gymnasium.Env[Floats, Floats]):
    """One structure of docked Modboats. Spaces with units, reward and episode: `host/docs/environments.md`."""

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(
        self,
        *,
        scenario: str = "holonomic-1",
        fidelity: Fidelity = "module",
        task: Task = "velocity",
        action: Action = "swing",
        contact: Contact = "penalty",
        duration_s: float = 90.0,
    ) -> None:
        """As `Options` says. Raises `ValueError` with the key that cannot be."""
        options = Options(
            scenario=scenario,
            fidelity=fidelity,
            task=task,
            action=action,
            contact=contact,
            duration_s=duration_s,
        )
        self.render_mode = None
        self._batch = options.batch(1, autoreset=False, threads=1)
        self._is_seeded = False
        self.observation_space = _core.observation_space(self._batch)
        self.action_space = _core.action_space(self._batch)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Floats, dict[str, Any]]:
        """Begins an episode. The same seed gives the same episode, and the same ones after it."""
        super().reset(seed=seed)
        if seed is None and not self._is_seeded:
            seed = int(self.np_random.integers(2**63))
        self._is_seeded = True
        observations, info = self._batch.reset([seed])
        return observations[0], _core.info_of(self._batch, info[0])

    def step(self, action: Floats) -> tuple[Floats, float, bool, bool, dict[str, Any]]:
        """One cycle of every module."""
        row = np.asarray(action, dtype=np.float64)[np.newaxis]
        observations, rewards, terminated, truncated, info = self._batch.step(row)
        told = _core.info_of(self._batch, info[0])
        return observations[0], float(rewards[0]), bool(terminated[0]), bool(truncated[0]), told

    def baseline(self, planner: Planner = "exact") -> Floats:
        """The action of the paper's controller with this planner, now."""
        action: Floats = self._batch.baseline(planner)[0]
        return action
