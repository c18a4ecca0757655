"""PettingZoo: one structure, one agent a module."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from . import _core
from ._core import BOUNDED, SHARED, Contact, Fidelity, Floats, Options, Planner, Space, Task

PER_MODULE = 3
"""Numbers of one module's action."""

_SIDES = 4


class FlotillaParallelEnv(ParallelEnv[str, Floats, Floats]):
    """Every module is an agent: it sees what all see, its own tail and those of its docked neighbours, and acts by its own swing.

    Observation of one agent, 28 numbers: the 12 that a structure's observation begins with; its own centre in S, m, sway and surge;
    sine and cosine of where its tail will rest; for each side, right, left, ahead, behind: 1 if a module is docked there, and sine and
    cosine of where that one's tail will rest, zeros if not. All agents have the same reward.
    """

    metadata: dict[str, Any] = {"name": "flotilla_v0", "render_modes": [], "is_parallelizable": True}

    def __init__(
        self,
        *,
        scenario: str = "holonomic-1",
        fidelity: Fidelity = "module",
        task: Task = "velocity",
        contact: Contact = "penalty",
        duration_s: float = 90.0,
    ) -> None:
        """As `Options` says."""
        options = Options(
            scenario=scenario, fidelity=fidelity, task=task, contact=contact, duration_s=duration_s
        )
        self.render_mode = None
        self._batch = batch = options.batch(1, autoreset=False, threads=1)
        self._is_seeded = False
        self._state = np.zeros(batch.observation_size)
        self.possible_agents = [f"module_{number}" for number in range(1, batch.modules + 1)]
        self.agents: list[str] = []
        self._place, self._fixed = _pick(batch.positions_m, batch.neighbours)
        high = np.full(self._fixed.shape[1], np.inf)
        high[BOUNDED] = high[SHARED + 2 :] = 1.0
        low, most = batch.action_low[:PER_MODULE], batch.action_high[:PER_MODULE]
        self.observation_spaces = {
            agent: _core.box(-high, high) for agent in self.possible_agents
        }
        self.action_spaces = {
            agent: _core.box(low, most) for agent in self.possible_agents
        }

    def observation_space(self, agent: str) -> Space:
        """That of this agent; all are alike."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Space:
        """That of this agent; all are alike."""
        return self.action_spaces[agent]

    def state(self) -> Floats:
        """The observation of the whole structure."""
        return self._state

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Floats], dict[str, dict[str, Any]]]:
        """Begins an episode. The same seed gives the same episode, and the same ones after it."""
        if seed is None and not self._is_seeded:
            seed = int(np.random.default_rng().integers(2**63))
        self._is_seeded = True
        observations, info = self._batch.reset([seed])
        self.agents = list(self.possible_agents)
        return self._seen(observations[0]), self._each(_core.info_of(self._batch, info[0]))

    def step(
        self, actions: dict[str, Floats]
    ) -> tuple[
        dict[str, Floats],
        dict[str, float],
        dict[str, bool],
        dict[str, bool],
        dict[str, dict[str, Any]],
    ]:
        """One cycle of every module."""
        if not self.agents:
            return {}, {}, {}, {}, {}
        row = np.concatenate([actions[agent] for agent in self.possible_agents])[np.newaxis]
        observations, rewards, terminated, truncated, info = self._batch.step(row)
        is_terminated, is_truncated = bool(terminated[0]), bool(truncated[0])
        result = (
            self._seen(observations[0]),
            dict.fromkeys(self.agents, float(rewards[0])),
            dict.fromkeys(self.agents, is_terminated),
            dict.fromkeys(self.agents, is_truncated),
            self._each(_core.info_of(self._batch, info[0])),
        )
        if is_terminated or is_truncated:
            self.agents = []
        return result

    def render(self) -> None:
        """There is nothing to see; `flotilla run` draws pictures."""

    def close(self) -> None:
        """Nothing is left open."""

    def baseline(self, planner: Planner = "exact") -> dict[str, Floats]:
        """The actions of the paper's controller with this planner, now."""
        rows = self._batch.baseline(planner)[0].reshape(-1, PER_MODULE)
        return dict(zip(self.possible_agents, rows, strict=True))

    def _seen(self, state: Floats) -> dict[str, Floats]:
        self._state = state
        # A place for what is nowhere.
        rows = np.append(state, 0.0)[self._place] + self._fixed
        return dict(zip(self.possible_agents, rows, strict=True))

    def _each(self, told: dict[str, Any]) -> dict[str, dict[str, Any]]:
        return {agent: dict(told) for agent in self.possible_agents}


def _pick(
    positions_m: Floats, neighbours: list[list[tuple[int, int]]]
) -> tuple[NDArray[np.intp], Floats]:
    """For each agent: the places in the structure's observation that it sees, and what never changes."""
    modules = len(positions_m)
    nowhere = SHARED + 2 * modules
    width = SHARED + 4 + 3 * _SIDES
    place = np.full((modules, width), nowhere, dtype=np.intp)
    fixed = np.zeros((modules, width))
    own = SHARED + 2 * np.arange(modules)
    place[:, :SHARED] = np.arange(SHARED)
    fixed[:, SHARED : SHARED + 2] = positions_m
    place[:, SHARED + 2], place[:, SHARED + 3] = own, own + 1
    for axis, pairs in enumerate(neighbours):
        for one, other in pairs:
            for module, beside, side in [(one, other, 2 * axis), (other, one, 2 * axis + 1)]:
                at = SHARED + 4 + 3 * side
                fixed[module, at] = 1.0
                place[module, at + 1 : at + 3] = [own[beside], own[beside] + 1]
    return place, fixed
