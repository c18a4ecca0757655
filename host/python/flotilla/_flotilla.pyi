from collections.abc import Sequence
from typing import Any, ClassVar, Literal, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

PlannerName = Literal["exact", "potential-field"]
LossTolerance = Literal["prefer", "require", "power", "off"]
Outcome = Literal["planned", "repeated", "held"]

@final
class Plan:
    """One decision: a transition and a swim cycle for every module."""

    @property
    def outcome(self) -> Outcome: ...
    @property
    def centerline_rad(self) -> NDArray[np.float64]: ...
    @property
    def amplitude_rad(self) -> NDArray[np.float64]: ...
    @property
    def from_rad(self) -> NDArray[np.float64] | None: ...
    @property
    def to_rad(self) -> NDArray[np.float64] | None: ...
    @property
    def via_rad(self) -> NDArray[np.float64] | None: ...
    @property
    def transition_s(self) -> float: ...
    @property
    def wrench(self) -> NDArray[np.float64]: ...
    @property
    def error(self) -> float: ...
    @property
    def travel_rad(self) -> float: ...
    @property
    def clearance_m(self) -> float | None: ...
    @property
    def guarantee_m(self) -> float | None: ...
    @property
    def loss_tolerant(self) -> bool: ...
    @property
    def power_tolerant(self) -> bool: ...
    @property
    def outside_envelope(self) -> bool: ...
    @property
    def reason(self) -> str | None: ...
    @property
    def planner(self) -> PlannerName: ...
    @property
    def solve_us(self) -> int: ...
    def to_dict(self) -> dict[str, Any]: ...

def plan(
    cells: ArrayLike,
    demand: ArrayLike,
    tail_rad: ArrayLike | None = None,
    *,
    scenario: str | None = None,
    planner: PlannerName | None = None,
    loss_tolerant: LossTolerance | None = None,
) -> Plan: ...

@final
class EnvironmentBatch:
    """Many learning environments; `flotilla.environments` makes the interfaces of Gymnasium and PettingZoo of it."""

    INFO: ClassVar[list[str]]
    def __new__(
        cls,
        num_envs: int,
        *,
        scenario: str,
        fidelity: Literal["module", "cycle"],
        task: Literal["velocity", "station", "legs"],
        action: Literal["swing", "wrench"],
        contact: Literal["penalty", "terminate"],
        duration_s: float,
        autoreset: bool,
        threads: int = 0,
    ) -> EnvironmentBatch: ...
    @property
    def num_envs(self) -> int: ...
    @property
    def modules(self) -> int: ...
    @property
    def observation_size(self) -> int: ...
    @property
    def action_low(self) -> NDArray[np.float64]: ...
    @property
    def action_high(self) -> NDArray[np.float64]: ...
    @property
    def positions_m(self) -> NDArray[np.float64]: ...
    @property
    def neighbours(self) -> list[list[tuple[int, int]]]: ...
    def reset(
        self, seeds: Sequence[int | None], chosen: Sequence[bool] | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    def step(
        self, actions: ArrayLike
    ) -> tuple[
        NDArray[np.float64],
        NDArray[np.float64],
        NDArray[np.bool_],
        NDArray[np.bool_],
        NDArray[np.float64],
    ]: ...
    def baseline(self, planner: PlannerName) -> NDArray[np.float64]: ...
