"""Uses every function as a careful user does; mypy holds it against the stubs."""

from typing import assert_type

import flotilla
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
CELLS = [[0, 0], [1, 0], [2, 0]]


def plans() -> None:
    plan = flotilla.plan(CELLS, [0.02, 0.0, 0.0], planner="exact", loss_tolerant="require")
    assert_type(plan.amplitude_rad, Floats)
    assert_type(plan.to_rad, Floats | None)
    planner = flotilla.Planner(np.array(CELLS), scenario="holonomic-1")
    assert_type(planner.plan((0.0, 0.0, 0.0), "previous"), flotilla.Plan)
    assert_type(planner.batch(np.zeros((4, 3)), threads=0).error, Floats)
    assert_type(flotilla.envelope(CELLS).gauge([[0.0, 0.0, 1.0]]), Floats)
    assert_type(flotilla.transition(CELLS, [0.0] * 3, [0.0] * 3, [1.0] * 3), flotilla.Transition | None)


def simulations() -> None:
    boats = flotilla.Simulation("nine", [1, 2], threads=2)
    boats.step_wrench([0.0, 0.1, 0.0])
    assert_type(boats.position_m, Floats)
    rovs = flotilla.RovSimulation("bluerov1", 2, eta=np.zeros(6))
    rovs.step(0.1, pwm_us=[1500.0] * 6, voltage_v=16.0)
    eta, nu = flotilla.simulate(flotilla.vehicle("bluerov1"), [1.0], tau=[0.0] * 6)
    assert_type(eta, Floats)
    assert_type(nu, Floats)
    assert_type(flotilla.run("nine", seed=3).t_s, Floats)


def reconfigurations() -> None:
    found = flotilla.reconfigure("i-to-l", criterion="euclidean", manner="paper")
    assert_type(found.energy_total_j, float)
    route = flotilla.route(np.zeros((4, 4), dtype=bool), [0, 0], [3, 3], algorithm="a-star")
    assert_type(route.length, float | None)


def logs() -> None:
    log = flotilla.read_log("log.mcap", ["/fix"])
    assert_type(log, flotilla.Log)
    assert_type(log.whole, bool)
    print(log["/fix"]["t_s"], log.frame("/fix").describe())
    assert_type(flotilla.identify(["log.mcap"], scale="thrust").constant("mass_sway_kg"), tuple[float, float, float])
