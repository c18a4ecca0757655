"""What all environments share: choices by name, spaces, and how a batch is made."""

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, cast

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from .._flotilla import EnvironmentBatch

Fidelity: TypeAlias = Literal["module", "cycle"]
Task: TypeAlias = Literal["velocity", "station", "legs"]
Action: TypeAlias = Literal["swing", "wrench"]
Contact: TypeAlias = Literal["penalty", "terminate"]
Planner: TypeAlias = Literal["exact", "potential-field"]

Floats: TypeAlias = NDArray[np.float64]
Bools: TypeAlias = NDArray[np.bool_]
Space: TypeAlias = spaces.Space[Floats]

SHARED = 12
"""Numbers of an observation before those of the tails."""

BOUNDED = [6, 7]
"""Sine and cosine of the heading error among them."""


@dataclass(frozen=True, kw_only=True)
class Options:
    """What an environment is made of.

    `scenario`: a name that the program knows, or a TOML file, which says structure, modules, water, motors and radio.
    `fidelity`: `"module"`, the firmware on simulated motors, or `"cycle"`, the mean wrench of each cycle.
    `task`: `"velocity"` or `"station"`, drawn at each reset, or `"legs"`, those of the scenario.
    `action`: `"swing"`, three numbers a module, or `"wrench"`, for which the exact planner finds the cycles.
    `contact`: what follows when tails touch: `"penalty"`, or `"terminate"` as well.
    `duration_s`: length of an episode, s.
    """

    scenario: str = "holonomic-1"
    fidelity: Fidelity = "module"
    task: Task = "velocity"
    action: Action = "swing"
    contact: Contact = "penalty"
    duration_s: float = 90.0

    def batch(self, num_envs: int, *, autoreset: bool, threads: int) -> EnvironmentBatch:
        """So many environments; `threads` of zero are all cores."""
        return EnvironmentBatch(
            num_envs,
            scenario=self.scenario,
            fidelity=self.fidelity,
            task=self.task,
            action=self.action,
            contact=self.contact,
            duration_s=self.duration_s,
            autoreset=autoreset,
            threads=threads,
        )


def box(low: Floats, high: Floats) -> Space:
    """All numbers between these."""
    return cast(Space, spaces.Box(low, high, dtype=np.float64))


def observation_space(batch: EnvironmentBatch) -> Space:
    """Sines and cosines are bounded, lengths and speeds are not."""
    high = np.full(batch.observation_size, np.inf)
    high[BOUNDED] = 1.0
    high[SHARED:] = 1.0
    return box(-high, high)


def action_space(batch: EnvironmentBatch) -> Space:
    """All modules one after the other, or a wrench."""
    return box(batch.action_low, batch.action_high)


def info_of(batch: EnvironmentBatch, row: Floats) -> dict[str, Any]:
    """What is told of one environment beside observation and reward, by name."""
    return dict(zip(batch.INFO, row.tolist(), strict=True))
