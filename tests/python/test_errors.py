"""What cannot be is an exception with the program's words."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import flotilla
import numpy as np
import pytest
from program import TOP, answers

ROW = [[0, 0], [1, 0], [2, 0]]
NONE = [0.0, 0.0, 0.0]
ZERO = {"fx_n": 0.0, "fy_n": 0.0, "tau_nm": 0.0}


@pytest.mark.parametrize(
    "request_, call",
    [
        (
            {"cells": ROW, "demand": ZERO, "tail_rad": [1.0]},
            lambda: flotilla.plan(ROW, NONE, [1.0]),
        ),
        (
            {"cells": ROW, "demand": {**ZERO, "fx_n": 1e7}},
            lambda: flotilla.plan(ROW, [1e7, 0, 0]),
        ),
        (
            {"cells": [[0, 0], [2, 0]], "demand": ZERO},
            lambda: flotilla.plan([[0, 0], [2, 0]], NONE),
        ),
        (
            {"cells": [[0, 0], [0, 0]], "demand": ZERO},
            lambda: flotilla.envelope([[0, 0], [0, 0]]),
        ),
        (
            {"cells": ROW, "demand": ZERO, "tail_rad": "previous"},
            lambda: flotilla.Planner(ROW).plan(NONE, "previous"),
        ),
        (
            {"cells": ROW, "demand": ZERO, "tail_rad": [1e7, 0.0, 0.0]},
            lambda: flotilla.plan(ROW, NONE, [1e7, 0.0, 0.0]),
        ),
    ],
)
def test_a_plans_mistake_is_told_as_the_program_tells_it(request_: Any, call: Callable[[], Any]) -> None:
    [answer] = answers(["plan"], [request_], fails=True)
    with pytest.raises(ValueError) as caught:
        call()
    assert str(caught.value) == answer["error"]


@pytest.mark.parametrize(
    "request_, call",
    [
        (
            {"vehicle": "bluerov1", "tau": [0, 0, 0], "at_s": [1.0]},
            lambda: flotilla.simulate("bluerov1", [1.0], tau=NONE),
        ),
        (
            {"vehicle": "bluerov1", "tau": [0] * 6, "at_s": [-1.0]},
            lambda: flotilla.simulate("bluerov1", [-1.0], tau=np.zeros(6)),
        ),
        (
            {"vehicle": "bluerov1", "pwm_us": [1500.0] * 6, "voltage_v": 25.0, "at_s": [1.0]},
            lambda: flotilla.simulate("bluerov1", [1.0], pwm_us=[1500.0] * 6, voltage_v=25.0),
        ),
    ],
)
def test_a_motions_mistake_is_told_as_the_program_tells_it(request_: Any, call: Callable[[], Any]) -> None:
    request_ = {"eta": [0.0] * 6, "nu": [0.0] * 6, **request_}
    [answer] = answers(["simulate"], [request_], fails=True)
    with pytest.raises(ValueError) as caught:
        call()
    assert str(caught.value) == answer["error"]


BOX = np.zeros((3, 4), dtype=bool)


@pytest.mark.parametrize(
    "kind, words, call",
    [
        (ValueError, "demand has the shape [2]: must be (3,)", lambda: flotilla.plan(ROW, [0.0, 0.0])),
        (ValueError, "cells has the shape [3]: must be (n, 2)", lambda: flotilla.plan([1, 2, 3], NONE)),
        (TypeError, "cells: must be whole numbers, not float64", lambda: flotilla.plan([[0.5, 0.0]], NONE)),
        (TypeError, "demand: ", lambda: flotilla.plan(ROW, ["a", "b", "c"])),
        (ValueError, "planner: unknown variant `best`", lambda: flotilla.plan(ROW, NONE, planner="best")),  # type: ignore[arg-type]
        (ValueError, "no built-in scenario of that name", lambda: flotilla.plan(ROW, NONE, scenario="none")),
        (ValueError, "demands[1]: demand.fx_n = inf N", lambda: flotilla.Planner(ROW).batch([NONE, [np.inf, 0, 0]])),
        (ValueError, "tail_rad has the shape [1, 2]", lambda: flotilla.Planner(ROW).batch([NONE], [[0.0, 0.0]])),
        (ValueError, "threads = 5000", lambda: flotilla.Planner(ROW).batch([NONE], threads=5000)),
        (OverflowError, "", lambda: flotilla.Planner(ROW).batch([NONE], threads=-1)),
        (ValueError, "amplitude_rad[0, 1] = 0.3 rad", lambda: flotilla.Simulation().step_swings(NONE, [1.0, 0.3, 1.0])),
        (ValueError, "wrench has the shape [2]", lambda: flotilla.Simulation().step_wrench([1.0, 2.0])),
        (ValueError, "takes one of tau, thrust_n", lambda: flotilla.RovSimulation("bluerov1").step(1.0)),
        (ValueError, "thrust_n has the shape [2]", lambda: flotilla.RovSimulation("bluerov1").step(1.0, thrust_n=[1, 2])),
        (ValueError, "no such file, and no built-in vehicle", lambda: flotilla.RovSimulation("submarine")),
        (ValueError, "vehicle: missing field", lambda: flotilla.RovSimulation({"mass_kg": 3.0})),
        (ValueError, "no such file", lambda: flotilla.Map("nowhere.map")),
        (ValueError, "must be (y, x) or (z, y, x)", lambda: flotilla.Map(np.zeros(3))),
        (ValueError, "goal [9, 1]: is outside the map, whose last is [4, 3]", lambda: flotilla.route(BOX, [0, 0], [9, 1])),
        (ValueError, "algorithm: unknown variant", lambda: flotilla.route(BOX, [0, 0], [1, 1], algorithm="b-star")),  # type: ignore[arg-type]
        (ValueError, "--parallel is for --manner best", lambda: flotilla.reconfigure("i-to-l", manner="paper", parallel="time")),
        (ValueError, "time_limit_s = 0 s", lambda: flotilla.reconfigure("i-to-l", time_limit_s=0.0)),
        (ValueError, "nowhere.mcap: No such file", lambda: flotilla.read_log("nowhere.mcap")),
        (ValueError, "nowhere.mcap: No such file", lambda: flotilla.identify(["nowhere.mcap"])),
        (ValueError, "no log was given", lambda: flotilla.identify([])),
        (RuntimeError, "nowhere/log.mcap", lambda: flotilla.run("holonomic-1", log="nowhere/log.mcap")),
    ],
)
def test_mistakes_are_named(kind: type[Exception], words: str, call: Callable[[], Any]) -> None:
    with pytest.raises(kind) as caught:
        call()
    assert words in str(caught.value)


def test_files_that_are_something_else(tmp_path: Path) -> None:
    file = tmp_path / "scenario.toml"
    own = (TOP / "host" / "scenarios" / "holonomic-1.toml").read_text()
    file.write_text(own + "[modboat]\npitch_m = -1.0\n")
    line = file.read_text().count("\n")
    with pytest.raises(ValueError, match=rf"scenario\.toml:{line}: .*pitch_m"):
        flotilla.plan(ROW, NONE, scenario=str(file))
    with pytest.raises(ValueError, match="not a log"):
        flotilla.read_log(file)
    log = tmp_path / "log.mcap"
    flotilla.run("holonomic-1", log=log)
    with pytest.raises(ValueError, match="has no topic /nothing"):
        flotilla.read_log(log, ["/fix", "/nothing"])
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(log.read_bytes()[: log.stat().st_size // 2])
    assert flotilla.read_log(log).whole and not flotilla.read_log(cut).whole
