"""Gymnasium: many structures at once, stepped in Rust on all cores."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from . import _core
from ._core import Action, Bools, Contact, Fidelity, Floats, Options, Planner, Task


class FlotillaVectorEnv(VectorEnv[Floats, Floats, NDArray[Any]]):
    """A batch of `FlotillaEnv`; an environment does here what it does alone with the same seed and actions.

    Autoreset: the step after the last one of an episode begins the next, whatever its action.
    """

    metadata: dict[str, Any] = {
        "render_modes": [],
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }

    def __init__(
        self,
        num_envs: int,
        *,
        scenario: str = "holonomic-1",
        fidelity: Fidelity = "module",
        task: Task = "velocity",
        action: Action = "swing",
        contact: Contact = "penalty",
        duration_s: float = 90.0,
        threads: int = 0,
    ) -> None:
        """As `Options` says, on `threads` threads; on all cores if that is zero."""
        options = Options(
            scenario=scenario,
            fidelity=fidelity,
            task=task,
            action=action,
            contact=contact,
            duration_s=duration_s,
        )
        self.num_envs = num_envs
        self.render_mode = None
        self._batch = options.batch(num_envs, autoreset=True, threads=threads)
        self._is_seeded = False
        self.single_observation_space = _core.observation_space(self._batch)
        self.single_action_space = _core.action_space(self._batch)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._all = np.ones(num_envs, dtype=np.bool_)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Floats, dict[str, Any]]:
        """Begins episodes: of all, or of those in `options["reset_mask"]`; rows of the others are zero.

        A seed that is one number counts up from environment to environment.
        """
        first = seed if isinstance(seed, int) else None
        super().reset(seed=first)
        mask: Bools | None = (options or {}).get("reset_mask")
        if isinstance(seed, int):
            seeds: list[int | None] = [seed + index for index in range(self.num_envs)]
        elif seed is not None:
            seeds = list(seed)
        elif self._is_seeded:
            seeds = [None] * self.num_envs
        else:
            seeds = self.np_random.integers(2**63, size=self.num_envs).tolist()
        self._is_seeded = True
        observations, info = self._batch.reset(seeds, None if mask is None else mask.tolist())
        return observations, self._told(info, self._all if mask is None else mask)

    def step(self, actions: Floats) -> tuple[Floats, Floats, Bools, Bools, dict[str, Any]]:
        """One cycle of every module of every structure."""
        observations, rewards, terminated, truncated, info = self._batch.step(actions)
        return observations, rewards, terminated, truncated, self._told(info, self._all)

    def baseline(self, planner: Planner = "exact") -> Floats:
        """The actions of the paper's controller with this planner, now."""
        return self._batch.baseline(planner)

    def _told(self, info: Floats, mask: Bools) -> dict[str, Any]:
        told: dict[str, Any] = {}
        for column, name in enumerate(self._batch.INFO):
            told[name] = info[:, column]
            told[f"_{name}"] = mask
        return told
