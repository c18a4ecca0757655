from collections.abc import Sequence
from os import PathLike
from typing import Any, ClassVar, Literal, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "Envelope",
    "EnvironmentBatch",
    "Identified",
    "Map",
    "Plan",
    "Planner",
    "Plans",
    "Reconfiguration",
    "Route",
    "RovSimulation",
    "Run",
    "Simulation",
    "Transition",
    "envelope",
    "identify",
    "plan",
    "read_log",
    "reconfigure",
    "route",
    "run",
    "simulate",
    "transition",
    "vehicle",
]

_PlannerName = Literal["exact", "potential-field"]
_LossTolerance = Literal["prefer", "require", "power", "off"]
_Outcome = Literal["planned", "repeated", "held"]
_Algorithm = Literal["theta", "basic-theta", "a-star", "a-star-smoothed"]

_Floats = NDArray[np.float64]
_Bools = NDArray[np.bool_]

@final
class Plan:
    """One decision: a transition and a swim cycle for every module."""

    @property
    def outcome(self) -> _Outcome:
        """What kind of decision it is."""
    @property
    def centerline_rad(self) -> _Floats:
        """Centerline of each module's swing, shape (modules,), counter-clockwise from the sway axis."""
    @property
    def amplitude_rad(self) -> _Floats:
        """Amplitude of each module's swing, shape (modules,); its sign chooses the end at which the cycle starts, 0 rests."""
    @property
    def from_rad(self) -> _Floats | None:
        """Where each tail turns from before the cycle, shape (modules,); None where no tail turns."""
    @property
    def to_rad(self) -> _Floats | None:
        """Where it turns to; unwrapped, so that the sign of `to_rad - from_rad` is the way round."""
    @property
    def via_rad(self) -> _Floats | None:
        """Where it is between the two steps of a transition that has two."""
    @property
    def transition_s(self) -> float:
        """How long the transition takes, s."""
    @property
    def wrench(self) -> _Floats:
        """Mean wrench of the cycle in the structure frame, shape (3,): sway N, surge N, yaw N m."""
    @property
    def error(self) -> float:
        """Weighted error relative to the demand; N for a zero demand."""
    @property
    def travel_rad(self) -> float:
        """Sum of all rotations of the transition."""
    @property
    def clearance_m(self) -> float | None:
        """Least distance between the surfaces of two tails; None where no two can meet."""
    @property
    def guarantee_m(self) -> float | None:
        """The same for tails as far off as modules let them be; None where nothing is guaranteed."""
    @property
    def loss_tolerant(self) -> bool:
        """Whether any modules may miss the plan without a collision."""
    @property
    def power_tolerant(self) -> bool:
        """Whether moreover any module may stop anywhere in it."""
    @property
    def outside_envelope(self) -> bool:
        """Whether the demand lies outside what the modules could give."""
    @property
    def reason(self) -> str | None:
        """Why nothing moves, where nothing does."""
    @property
    def planner(self) -> _PlannerName:
        """Which planner made it."""
    @property
    def solve_us(self) -> int:
        """How long that took, µs."""
    def to_dict(self) -> dict[str, Any]:
        """What `flotilla plan` prints."""

@final
class Plans:
    """Many plans by column: row i is of demand i. Each column is copied when it is asked for."""

    def __len__(self) -> int: ...
    @property
    def outcome(self) -> NDArray[np.uint8]:
        """0 planned, 1 repeated, 2 held; shape (n,), as all that is said once a plan."""
    @property
    def centerline_rad(self) -> _Floats:
        """Shape (n, modules), as all that is said of each module."""
    @property
    def amplitude_rad(self) -> _Floats: ...
    @property
    def from_rad(self) -> _Floats:
        """Not a number where no tail turns."""
    @property
    def via_rad(self) -> _Floats:
        """Not a number where the transition has no two steps."""
    @property
    def to_rad(self) -> _Floats:
        """Not a number where no tail turns."""
    @property
    def wrench(self) -> _Floats:
        """Shape (n, 3)."""
    @property
    def error(self) -> _Floats: ...
    @property
    def travel_rad(self) -> _Floats: ...
    @property
    def transition_s(self) -> _Floats: ...
    @property
    def clearance_m(self) -> _Floats:
        """Not a number where no two tails can meet."""
    @property
    def guarantee_m(self) -> _Floats:
        """Not a number where nothing is guaranteed."""
    @property
    def loss_tolerant(self) -> _Bools: ...
    @property
    def outside_envelope(self) -> _Bools: ...

@final
class Planner:
    """A planner of one structure, which remembers its last plan. Calls from several threads take turns."""

    def __new__(
        cls,
        cells: ArrayLike,
        *,
        scenario: str | None = None,
        planner: _PlannerName | None = None,
        loss_tolerant: _LossTolerance | None = None,
    ) -> Planner: ...
    @property
    def cells(self) -> NDArray[np.int32]: ...
    @property
    def planner(self) -> _PlannerName: ...
    def plan(self, demand: ArrayLike, tail_rad: ArrayLike | Literal["previous"] | None = None) -> Plan:
        """The next plan of its stream: from angles, from where its last plan ends, or from tails that are not known."""
    def sequence(self, demands: ArrayLike, tail_rad: ArrayLike | Literal["previous"] | None = None) -> Plans:
        """A plan after the other, each from where the one before ends; `tail_rad` is for the first."""
    def batch(self, demands: ArrayLike, tail_rad: ArrayLike | None = None, *, threads: int = 1) -> Plans:
        """A plan for each demand by itself, whatever was planned before; `tail_rad` of shape (n, modules). 0 threads: all cores."""

@final
class Envelope:
    """The wrenches that a structure could give if no tail were in another's way."""

    @property
    def extremes(self) -> _Floats:
        """Greatest force and torque along each axis, alike both ways, shape (3,)."""
    def gauge(self, demands: ArrayLike) -> _Floats:
        """Demands of shape (n, 3): 0 for none, 1 on the border, infinite where nothing in that direction can be given at all."""
    def inside(self, demands: ArrayLike) -> _Bools:
        """Whether each can be given."""
    def boundary(self, demands: ArrayLike) -> _Floats:
        """The farthest wrench in the direction of each, shape (n, 3); not a number where there is none."""
    def locate(self, demand: ArrayLike) -> dict[str, Any]:
        """What `flotilla plan --envelope` prints for one demand."""

@final
class Transition:
    """A transition of least travel, in one step."""

    @property
    def from_rad(self) -> _Floats: ...
    @property
    def to_rad(self) -> _Floats:
        """Unwrapped: the sign of `to_rad - from_rad` is the way round."""
    @property
    def negated(self) -> bool:
        """Whether all amplitudes of the cycle are to be negated."""
    @property
    def travel_rad(self) -> float: ...
    @property
    def exact(self) -> bool:
        """Whether this is proved to be the least travel."""
    @property
    def duration_s(self) -> float: ...
    @property
    def ramp_s(self) -> float:
        """Length of each ramp from and to rest; 0 at constant speed."""

@final
class Run:
    """What a run leaves behind."""

    @property
    def summary(self) -> dict[str, Any]:
        """The figures, as `flotilla run --json` prints them."""
    @property
    def complaints(self) -> list[str]:
        """What was asked and not done."""
    @property
    def t_s(self) -> _Floats:
        """Times of the poses, about 20 a second, from the start of the first cycle; shape (n,)."""
    @property
    def position_m(self) -> _Floats:
        """True positions, shape (n, 2)."""
    @property
    def heading_rad(self) -> _Floats: ...
    @property
    def velocity_m_s(self) -> _Floats:
        """Shape (n, 2)."""
    @property
    def yaw_rate_rad_s(self) -> _Floats: ...
    @property
    def tail_t_s(self) -> _Floats:
        """Times of the tails' angles, about 50 a second."""
    @property
    def tail_rad(self) -> _Floats:
        """Shape (n, modules)."""
    @property
    def cycle_start_s(self) -> _Floats:
        """When each cycle begins, shape (cycles,)."""
    @property
    def demanded(self) -> _Floats:
        """What the controller asked for, shape (cycles, 3)."""
    @property
    def commanded(self) -> _Floats:
        """What the plan gives, shape (cycles, 3)."""

@final
class Simulation:
    """Tanks with Modboats: the firmware on simulated motors, the link and the water of `flotilla run`, without its pilot. n of them, each from its seed."""

    def __new__(
        cls,
        scenario: str = "holonomic-1",
        seeds: Sequence[int] | None = None,
        *,
        planner: _PlannerName = "exact",
        threads: int = 1,
    ) -> Simulation: ...
    def __len__(self) -> int: ...
    @property
    def modules(self) -> int: ...
    def step_wrench(self, wrench: ArrayLike) -> None:
        """One cycle of every tank by the planner: shape (3,) for all, or (n, 3)."""
    def step_swings(
        self, centerline_rad: ArrayLike, amplitude_rad: ArrayLike, direction: ArrayLike | None = None
    ) -> None:
        """One cycle by the swing of each module: shape (modules,) for all tanks, or (n, modules).

        `direction` is the way round to where a swing starts: 0 the shorter, 1 counter-clockwise, -1 clockwise.
        """
    @property
    def t_s(self) -> _Floats:
        """The tank's time, shape (n,): when the next cycle is decided, `lead_s` before the one that runs is over."""
    @property
    def position_m(self) -> _Floats:
        """True position in the world (x east, y north), shape (n, 2)."""
    @property
    def heading_rad(self) -> _Floats:
        """True heading of the surge axis, counter-clockwise from world x, unwrapped, shape (n,)."""
    @property
    def velocity_m_s(self) -> _Floats:
        """Shape (n, 2)."""
    @property
    def yaw_rate_rad_s(self) -> _Floats: ...
    @property
    def tail_rad(self) -> _Floats:
        """Where each tail rests when the running cycle is over, shape (n, modules)."""
    @property
    def centerline_rad(self) -> _Floats:
        """The running cycle, shape (n, modules); 0 before the first."""
    @property
    def amplitude_rad(self) -> _Floats: ...
    @property
    def wrench(self) -> _Floats:
        """Its mean wrench as planned, shape (n, 3)."""
    @property
    def contacts(self) -> NDArray[np.uint64]:
        """How often two tails touched so far."""
    @property
    def stuck(self) -> _Bools:
        """A module took no cycle any more, for longer than one is waited for."""

@final
class RovSimulation:
    """ROVs of one kind, each in a water of its own. Thrusters push what they are told from the first instant."""

    def __new__(
        cls,
        vehicle: str | dict[str, Any],
        count: int = 1,
        *,
        eta: ArrayLike | None = None,
        nu: ArrayLike | None = None,
    ) -> RovSimulation: ...
    def __len__(self) -> int: ...
    @property
    def t_s(self) -> float: ...
    @property
    def thrusters(self) -> int: ...
    @property
    def eta(self) -> _Floats:
        """Poses, shape (n, 6): x, y, z (m, north-east-down) and ZYX Euler angles in (-pi, pi]."""
    @property
    def nu(self) -> _Floats:
        """Velocities at the body origin, shape (n, 6)."""
    def step(
        self,
        duration_s: float,
        *,
        tau: ArrayLike | None = None,
        thrust_n: ArrayLike | None = None,
        pwm_us: ArrayLike | None = None,
        voltage_v: float | None = None,
        threads: int = 1,
    ) -> None:
        """Goes on under a wrench (6), thrusts or pulses (one a thruster): a row for all, or one for each."""

@final
class Reconfiguration:
    """A plan of ROVs, and what its execution came to."""

    def to_dict(self) -> dict[str, Any]:
        """What `flotilla reconfigure --json` prints."""
    @property
    def energy_navigate_j(self) -> float: ...
    @property
    def energy_balance_j(self) -> float: ...
    @property
    def energy_total_j(self) -> float: ...
    @property
    def time_s(self) -> float: ...
    @property
    def cost(self) -> float:
        """By the criterion, J or m."""
    @property
    def bound(self) -> float:
        """No order and assignment costs less, J or m; 0 where nothing is known."""
    @property
    def summary(self) -> dict[str, Any] | None:
        """The figures of its execution, where it was executed, as in `summary.json`."""

@final
class Map:
    """A map in 2D or 3D, from a file or of blocked cells `[y, x]` or `[z, y, x]`."""

    def __new__(cls, map: str | PathLike[str] | ArrayLike) -> Map: ...
    @property
    def last(self) -> list[int]:
        """The last place: `[x, y]` or `[x, y, z]`."""
    def route(self, start: ArrayLike, goal: ArrayLike, *, algorithm: _Algorithm = "theta") -> Route: ...

@final
class Route:
    """A way from a place to another."""

    @property
    def length(self) -> float | None:
        """In cells; None where there is no way, which is proved."""
    @property
    def path(self) -> NDArray[np.uint32] | None:
        """Corners, both ends included, shape (n, 2) or (n, 3)."""
    @property
    def expanded(self) -> int: ...
    @property
    def time_us(self) -> int: ...
    def to_dict(self) -> dict[str, Any]:
        """What `flotilla path --json` prints."""

@final
class Identified:
    """Constants of the boat."""

    def to_dict(self) -> dict[str, Any]:
        """What `flotilla identify --json` prints."""
    def to_toml(self) -> str:
        """Tables to paste into a scenario."""
    def constant(self, name: str) -> tuple[float, float, float]:
        """A value, and the ends of its 95 % interval."""

def plan(
    cells: ArrayLike,
    demand: ArrayLike,
    tail_rad: ArrayLike | None = None,
    *,
    scenario: str | None = None,
    planner: _PlannerName | None = None,
    loss_tolerant: _LossTolerance | None = None,
) -> Plan:
    """One plan: `flotilla plan` with one request. Cells of shape (n, 2), demand of shape (3,), angles of shape (n,)."""

def envelope(cells: ArrayLike, *, scenario: str | None = None) -> Envelope:
    """What modules in these cells could give: `flotilla plan --envelope`."""

def transition(
    cells: ArrayLike,
    from_rad: ArrayLike,
    centerline_rad: ArrayLike,
    amplitude_rad: ArrayLike,
    *,
    scenario: str | None = None,
    planner: _PlannerName | None = None,
) -> Transition | None:
    """The transition of least travel into a cycle, in one step; None where it is proved that there is none."""

def run(
    scenario: str = "holonomic-1",
    *,
    seed: int | None = None,
    planner: _PlannerName | None = None,
    log: str | PathLike[str] | None = None,
) -> Run:
    """A run in simulation: `flotilla run`. The log is written where a path is given."""

def simulate(
    vehicle: str | dict[str, Any],
    at_s: ArrayLike,
    *,
    eta: ArrayLike | None = None,
    nu: ArrayLike | None = None,
    tau: ArrayLike | None = None,
    pwm_us: ArrayLike | None = None,
    voltage_v: float | None = None,
) -> tuple[_Floats, _Floats]:
    """Poses and velocities at these times, each of shape (n, 6): `flotilla simulate` with one request."""

def vehicle(name: str) -> dict[str, Any]:
    """The body of a vehicle, by name or from its file, to be changed and simulated."""

def reconfigure(
    scenario: str,
    *,
    criterion: Literal["energy", "euclidean"] = "energy",
    manner: Literal["best", "paper"] = "best",
    order: Literal["exact", "paper"] | None = None,
    power: Literal["table", "fitted", "quadratic"] = "table",
    time_limit_s: float = 60.0,
    parallel: Literal["energy", "time"] | None = None,
    weight: float | None = None,
    execute: bool = False,
    seed: int | None = None,
    loss: float = 0.0,
) -> Reconfiguration:
    """Plans how ROVs change their configuration, and executes that in simulation: `flotilla reconfigure`."""

def route(
    map: Map | str | PathLike[str] | ArrayLike,
    start: ArrayLike,
    goal: ArrayLike,
    *,
    algorithm: _Algorithm = "theta",
) -> Route:
    """A shortest path: `flotilla path`. Places are `[x, y]` or `[x, y, z]`; in 2D the corners of cells."""

def read_log(
    path: str | PathLike[str], topics: Sequence[str] | None = None
) -> tuple[dict[str, dict[str, NDArray[Any]]], bool]: ...
def identify(logs: Sequence[str | PathLike[str]], *, scale: Literal["rotor", "thrust"] = "rotor") -> Identified:
    """Constants of the boat from logs of its runs, with intervals: `flotilla identify`."""

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
    def baseline(self, planner: _PlannerName) -> NDArray[np.float64]: ...
