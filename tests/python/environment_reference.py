"""The fidelity `cycle` of an environment once more, in numpy, written from the equations and not from the Rust.

One structure at a time, as a first version by hand would be. It is what the Rust is compared with, in what it computes and in how
long it takes. Numbers are the defaults of `host/scenarios/README.md`.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

PERIOD_S = 1.5
LEAD_S = 0.3
STEP_S = 0.5
AMPLITUDE_MIN_RAD, AMPLITUDE_MAX_RAD = 0.9, 2.6
TAIL_SPEED_RAD_S, TAIL_ACCELERATION_RAD_S2 = 0.8 * 13.0, 200.0
PITCH_M, TAIL_LENGTH_M, TAIL_WIDTH_M = 0.15, 0.09, 0.015
MASS_KG, INERTIA_KG_M2 = 1.0, 0.003
DRAG_N_S2_M2, YAW_DRAG_N_M_S2 = 4.5, 5e-4
ADDED = 1.5


def wrap(angle_rad: Floats) -> Floats:
    """The same angle in (−π, π]."""
    wrapped = np.mod(angle_rad, 2 * np.pi)
    return np.where(wrapped > np.pi, wrapped - 2 * np.pi, wrapped)


def in_structure(heading_rad: float, vector: Floats) -> Floats:
    """World to S: sway is (sin Θ, −cos Θ), surge (cos Θ, sin Θ)."""
    sin, cos = np.sin(heading_rad), np.cos(heading_rad)
    return np.array([[sin, -cos], [cos, sin]]) @ vector


@dataclass
class Reference:
    """One structure of modules at `positions_m` in S, at rest with every tail at zero."""

    positions_m: Floats
    position_m: Floats
    heading_rad: float
    velocity_m_s: Floats | None = None
    station_m: Floats | None = None
    heading_asked_rad: float = 0.0
    state: Floats = field(init=False)
    tails_rad: Floats = field(init=False)
    wrench: Floats = field(init=False)

    def __post_init__(self) -> None:
        # x, y in the world, Θ, sway, surge, Ω.
        self.state = np.concatenate([self.position_m, [self.heading_rad], np.zeros(3)])
        self.tails_rad = np.zeros(len(self.positions_m))
        self.wrench = np.zeros(3)
        modules = len(self.positions_m)
        arms_m = np.hypot(*self.positions_m.T)
        apart_m = np.hypot(*(self.positions_m[:, np.newaxis] - self.positions_m).T)
        self.pairs = np.argwhere(np.triu(apart_m > 0) & (apart_m < 1.1 * PITCH_M))
        self.mass_kg = ADDED * modules * MASS_KG
        self.inertia_kg_m2 = ADDED * np.sum(INERTIA_KG_M2 + MASS_KG * arms_m**2)
        self.drag = modules * DRAG_N_S2_M2
        self.yaw_drag = np.sum(DRAG_N_S2_M2 * arms_m**3 + YAW_DRAG_N_M_S2)

    def rates(self, state: Floats, wrench: Floats) -> Floats:
        """Time derivative of the state: equal added mass along both axes, quadratic drag, still water."""
        _, _, heading_rad, sway, surge, omega = state
        sin, cos = np.sin(heading_rad), np.cos(heading_rad)
        force = wrench[:2] - self.drag * np.array([sway, surge]) * np.abs([sway, surge])
        acceleration = force / self.mass_kg + omega * np.array([surge, -sway])
        turning = (wrench[2] - self.yaw_drag * omega * np.abs(omega)) / self.inertia_kg_m2
        return np.array(
            [sin * sway + cos * surge, -cos * sway + sin * surge, omega, *acceleration, turning]
        )

    def push(self, span_s: float, wrench: Floats) -> None:
        """RK4 in equal steps of at most STEP_S."""
        steps = int(np.ceil(span_s / STEP_S))
        for _ in range(steps):
            h = span_s / steps
            k1 = self.rates(self.state, wrench)
            k2 = self.rates(self.state + 0.5 * h * k1, wrench)
            k3 = self.rates(self.state + 0.5 * h * k2, wrench)
            k4 = self.rates(self.state + h * k3, wrench)
            self.state = self.state + h * (k1 + 2 * (k2 + k3) + k4) / 6

    def step(self, action: Floats) -> tuple[Floats, float, Floats]:
        """One cycle: what is seen, the reward, and the clearance of every motion of a pair, m."""
        centre, amplitude, way = action.reshape(-1, 3).T
        size = np.clip(np.abs(amplitude), AMPLITUDE_MIN_RAD, AMPLITUDE_MAX_RAD)
        amplitude = np.where(np.abs(amplitude) < AMPLITUDE_MIN_RAD / 2, 0.0, np.copysign(size, amplitude))
        turn = wrap(centre + amplitude - self.tails_rad)
        turn = np.where((way > 0.5) & (turn < 0), turn + 2 * np.pi, turn)
        turn = np.where((way < -0.5) & (turn > 0), turn - 2 * np.pi, turn)
        turning_s = float(np.round(1e6 * self.transition_s(np.max(np.abs(turn)))) * 1e-6)
        thrust = np.where(amplitude == 0.0, 0.0, 0.022 * np.abs(amplitude) - 0.019)
        x, y = self.positions_m.T
        force_x, force_y = -thrust * np.cos(centre), -thrust * np.sin(centre)
        wrench = np.array([force_x.sum(), force_y.sum(), (x * force_y - y * force_x).sum()])

        before = self.state
        self.push(LEAD_S, self.wrench)
        self.push(turning_s, np.zeros(3))
        self.push(PERIOD_S - LEAD_S, wrench)
        interval_s = turning_s + PERIOD_S
        motions = [(centre + amplitude, centre - amplitude, PERIOD_S)]
        if turning_s > 0:
            motions.append((self.tails_rad, self.tails_rad + turn, turning_s))
        clearance_m = np.array([
            least_clearance_m(self.positions_m[j] - self.positions_m[i], start[[i, j]], end[[i, j]], span_s)
            for start, end, span_s in motions
            for i, j in self.pairs
        ])
        self.tails_rad, self.wrench = self.tails_rad + turn, wrench
        moved = (self.state - before)[:3] / interval_s
        reward = self.reward(moved, interval_s) - float(np.sum(clearance_m < 0))
        return self.observe(moved), reward, clearance_m

    @staticmethod
    def transition_s(longest_rad: float) -> float:
        """From rest to rest within speed and acceleration of a tail."""
        ramp_s = TAIL_SPEED_RAD_S / TAIL_ACCELERATION_RAD_S2
        if longest_rad >= TAIL_SPEED_RAD_S * ramp_s:
            return longest_rad / TAIL_SPEED_RAD_S + ramp_s
        return float(2 * np.sqrt(longest_rad / TAIL_ACCELERATION_RAD_S2))

    def observe(self, moved: Floats) -> Floats:
        """What is seen after a step with these mean rates of x, y and Θ."""
        heading_rad = self.state[2]
        place = np.zeros(2) if self.station_m is None else self.station_m - self.state[:2]
        speed = np.zeros(2) if self.velocity_m_s is None else self.velocity_m_s
        off = self.heading_asked_rad - heading_rad
        tails = np.stack([np.sin(self.tails_rad), np.cos(self.tails_rad)], axis=1)
        parts = [
            in_structure(heading_rad, place),
            in_structure(heading_rad, speed),
            in_structure(heading_rad, moved[:2]),
            [np.sin(off), np.cos(off), moved[2]],
            self.wrench,
            tails.ravel(),
        ]
        return np.concatenate(parts)

    def reward(self, moved: Floats, interval_s: float) -> float:
        """Without contacts."""
        if self.station_m is None:
            missed = np.hypot(*(moved[:2] - self.velocity_m_s)) / 0.04
        else:
            missed = np.hypot(*(self.station_m - self.state[:2])) / 0.15
        turned = np.abs(wrap(self.heading_asked_rad - self.state[2]))
        return float(-interval_s / PERIOD_S * (missed + turned))


def least_clearance_m(offset_m: Floats, start: Floats, end: Floats, span_s: float) -> float:
    """Least distance between the surfaces of two tails on a straight way in phase space, looked at each millisecond."""
    share = np.linspace(0.0, 1.0, 1 + int(np.ceil(span_s * 1e3)))[:, np.newaxis]
    angles = start + share * (end - start)
    one = TAIL_LENGTH_M * np.stack([np.cos(angles[:, 0]), np.sin(angles[:, 0])], axis=1)
    other = TAIL_LENGTH_M * np.stack([np.cos(angles[:, 1]), np.sin(angles[:, 1])], axis=1)
    tips = [(np.zeros_like(one), one), (offset_m + np.zeros_like(other), offset_m + other)]
    (a, b), (c, d) = tips
    apart = np.min([
        _to_segment(a, c, d), _to_segment(b, c, d), _to_segment(c, a, b), _to_segment(d, a, b),
    ], axis=0)
    crosses = (_side(a, b, c) * _side(a, b, d) < 0) & (_side(c, d, a) * _side(c, d, b) < 0)
    return float(np.min(np.where(crosses, 0.0, apart)) - TAIL_WIDTH_M)


def _to_segment(point: Floats, one: Floats, other: Floats) -> Floats:
    along = other - one
    share = np.clip(np.sum((point - one) * along, axis=1) / np.sum(along**2, axis=1), 0.0, 1.0)
    return np.hypot(*(point - one - share[:, np.newaxis] * along).T)


def _side(one: Floats, other: Floats, point: Floats) -> Floats:
    (x, y), (u, v) = (other - one).T, (point - one).T
    return x * v - y * u
