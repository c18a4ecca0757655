"""Simulations step: whatever their number and threads, the same; and the interpreter goes on meanwhile."""

import threading
import time
from collections.abc import Callable
from typing import Any

import flotilla
import numpy as np
import pytest

COLUMNS = ["t_s", "position_m", "heading_rad", "velocity_m_s", "yaw_rate_rad_s", "tail_rad", "wrench", "contacts", "stuck"]


def test_a_tank_of_many_is_one_alone() -> None:
    seeds = [3, 1, 4, 1, 5]
    wrenches = np.random.default_rng(20).uniform(-1, 1, (3, len(seeds), 3)) * [0.04, 0.04, 0.003]
    many = flotilla.Simulation("holonomic-1", seeds, threads=2)
    assert (len(many), many.modules) == (5, 3)
    alone = [flotilla.Simulation("holonomic-1", [seed]) for seed in seeds]
    for step in wrenches:
        many.step_wrench(step)
        for one, wrench in zip(alone, step, strict=True):
            one.step_wrench(wrench)
    for name in COLUMNS:
        np.testing.assert_array_equal(getattr(many, name), np.concatenate([getattr(one, name) for one in alone]))
    assert np.ptp(many.position_m[:, 0]) > 0


@pytest.mark.parametrize("planner", ["exact", "potential-field"])
def test_swings_of_a_wrench_do_the_same(planner: Any) -> None:
    by_wrench = flotilla.Simulation("nine", [2], planner=planner)
    by_swings = flotilla.Simulation("nine", [2])
    swum = 0
    for wrench in [[0.05, 0.0, 0.0], [0.05, 0.0, 0.0], [0.0, -0.08, 0.004], [0.02, 0.02, -0.004]]:
        before = by_wrench.tail_rad
        by_wrench.step_wrench(wrench)
        way = np.sign(np.round(by_wrench.tail_rad - before, 6))
        by_swings.step_swings(by_wrench.centerline_rad, by_wrench.amplitude_rad, way)
        # Of a transition in two steps the first is a step by itself, in which nothing swings.
        if by_wrench.amplitude_rad.any():
            swum += 1
            np.testing.assert_allclose(by_wrench.wrench[0], wrench, atol=2e-3)
        for name in COLUMNS:
            np.testing.assert_allclose(getattr(by_swings, name), getattr(by_wrench, name), atol=1e-12)
    assert swum >= 3 and by_wrench.contacts.tolist() == [0]


def test_a_boat_is_pushed_where_the_wrench_points() -> None:
    # Heading pi/2 of a scenario's first leg or zero: surge is (cos, sin) of the heading, sway (sin, -cos).
    boat = flotilla.Simulation("holonomic-1", [1])
    for _ in range(6):
        boat.step_wrench([0.0, 0.04, 0.0])
    heading = boat.heading_rad[0]
    surge = boat.velocity_m_s[0] @ [np.cos(heading), np.sin(heading)]
    sway = boat.velocity_m_s[0] @ [np.sin(heading), -np.cos(heading)]
    # At most the steady speed of the drag law: 0.04 N over three times 4.5 N s²/m².
    assert 0.3 * np.sqrt(0.04 / 13.5) < surge < np.sqrt(0.04 / 13.5)
    assert abs(sway) < 0.3 * surge


def test_thrusts_are_a_wrench() -> None:
    # The first two thrusters of a BlueROV1 push forward, 0.02 m below the origin: 10 N, and 10 N times 0.02 m about y.
    one, other = (flotilla.RovSimulation("bluerov1", 2) for _ in range(2))
    for _ in range(4):
        one.step(0.5, thrust_n=[5.0, 5.0, 0.0, 0.0, 0.0, 0.0])
        other.step(0.5, tau=np.tile([10.0, 0.0, 0.0, 0.0, 0.2, 0.0], (2, 1)), threads=2)
    assert (one.t_s, len(one), one.thrusters) == (2.0, 2, 6)
    np.testing.assert_allclose(one.eta, other.eta, atol=1e-9)
    np.testing.assert_allclose(one.nu, other.nu, atol=1e-9)
    assert one.nu[0, 0] > 0.3


def test_neutral_pulses_push_nothing() -> None:
    start = [0.5, 0.1, 0.0, 0.0, 0.0, 0.3]
    one, other = (flotilla.RovSimulation("bluerov1", nu=start) for _ in range(2))
    one.step(1.0, pwm_us=[1500.0] * 6, voltage_v=16.0)
    other.step(1.0, tau=np.zeros(6))
    np.testing.assert_array_equal(one.nu, other.nu)
    assert 0 < one.nu[0, 0] < 0.5


def ticks(work: Callable[[], Any]) -> int:
    """How often this thread came to its turn while another worked."""
    began, ended = threading.Event(), threading.Event()

    def run() -> None:
        began.set()
        work()
        ended.set()

    thread = threading.Thread(target=run)
    thread.start()
    began.wait()
    count = 0
    while not ended.is_set():
        time.sleep(0.001)
        count += 1
    thread.join()
    return count


def test_the_interpreter_goes_on_meanwhile() -> None:
    planner = flotilla.Planner([[x, y] for x in range(3) for y in range(3)])
    demands = np.random.default_rng(20).uniform(-1, 1, (400, 3)) * [0.1, 0.1, 0.01]
    boat = flotilla.Simulation("nine", [1, 2, 3, 4])
    rov = flotilla.RovSimulation("bluerov1", 20)
    # Were the lock held, one more tick could be made at most, between the event and the call.
    for work in [
        lambda: planner.batch(demands),
        lambda: planner.sequence(demands),
        lambda: boat.step_wrench([0.05, 0.0, 0.0]),
        lambda: rov.step(5.0, tau=[10.0, 0.0, 0.0, 0.0, 0.0, 1.0]),
        lambda: flotilla.run("holonomic-1"),
        lambda: flotilla.reconfigure("t-to-i-far"),
    ]:
        assert ticks(work) > 3
