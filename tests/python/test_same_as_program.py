"""Every function gives the numbers that the program prints, digit for digit."""

import csv
import json
from pathlib import Path
from typing import Any

import flotilla
import numpy as np
import pytest
from program import TOP, answers, flotilla as program, is_time, timeless

SEED = 20
ROW = [[0, 0], [1, 0], [2, 0]]
SQUARE = [[0, 0], [1, 0], [0, 1], [1, 1]]
PLANNERS = ["exact", "potential-field"]


def demands(count: int, seed: int = SEED) -> Any:
    """Most of them inside the envelope of three modules."""
    return np.random.default_rng(seed).uniform(-1.0, 1.0, (count, 3)) * [0.05, 0.05, 0.004]


def demand(row: Any) -> dict[str, float]:
    return dict(zip(["fx_n", "fy_n", "tau_nm"], map(float, row), strict=True))


def columns(plan: dict[str, Any], key: str) -> Any:
    """A list of a plan's JSON as an array."""
    part, name = key.split(".")
    return None if plan[part] is None else np.array([module[name] for module in plan[part]])


@pytest.mark.parametrize("planner", PLANNERS)
@pytest.mark.parametrize("cells", [ROW, SQUARE])
def test_a_stream_of_plans(planner: Any, cells: list[list[int]]) -> None:
    rng = np.random.default_rng(SEED)
    tails: list[Any] = [None]
    for turn in range(23):
        tails.append("previous" if turn % 3 else [float(a) for a in rng.uniform(-3, 3, len(cells))])
    wanted = demands(len(tails))
    requests = [
        {"cells": cells, "demand": demand(row), "tail_rad": tail} for row, tail in zip(wanted, tails, strict=True)
    ]
    expected = answers(["plan", "--planner", planner], requests)
    stream = flotilla.Planner(cells, planner=planner)
    turned = 0
    for row, tail, answer in zip(wanted, tails, expected, strict=True):
        plan = stream.plan(row, tail)
        assert timeless(plan.to_dict()) == timeless(answer)
        assert plan.outcome == answer["outcome"]
        assert plan.wrench.tolist() == list(answer["wrench"].values())
        assert (plan.error, plan.travel_rad) == (answer["error"], answer["travel_rad"])
        assert (plan.clearance_m, plan.guarantee_m) == (answer["clearance_m"], answer.get("guarantee_m"))
        assert (plan.loss_tolerant, plan.planner) == (answer["loss_tolerant"], planner)
        assert plan.reason == answer.get("reason")
        np.testing.assert_array_equal(plan.centerline_rad, columns(answer, "cycle.centerline_rad"))
        np.testing.assert_array_equal(plan.amplitude_rad, columns(answer, "cycle.amplitude_rad"))
        if answer["transition"] is None:
            assert plan.from_rad is None and plan.to_rad is None
        else:
            turned += 1
            np.testing.assert_array_equal(plan.from_rad, columns(answer, "transition.from_rad"))
            np.testing.assert_array_equal(plan.to_rad, columns(answer, "transition.to_rad"))
    assert turned > 3


def test_a_sequence_is_a_stream() -> None:
    wanted = demands(30)
    requests = [
        {"cells": SQUARE, "demand": demand(row), "tail_rad": "previous" if index else [0.1, 0.2, 3.0, -1.0]}
        for index, row in enumerate(wanted)
    ]
    expected = answers(["plan"], requests)
    plans = flotilla.Planner(SQUARE).sequence(wanted, [0.1, 0.2, 3.0, -1.0])
    assert len(plans) == 30
    for index, answer in enumerate(expected):
        np.testing.assert_array_equal(plans.centerline_rad[index], columns(answer, "cycle.centerline_rad"))
        np.testing.assert_array_equal(plans.amplitude_rad[index], columns(answer, "cycle.amplitude_rad"))
        if answer["transition"] is None:
            assert np.isnan(plans.to_rad[index]).all()
        else:
            np.testing.assert_array_equal(plans.to_rad[index], columns(answer, "transition.to_rad"))
        assert plans.error[index] == answer["error"]


@pytest.mark.parametrize("options", [[], ["--loss-tolerant", "require"], ["--planner", "potential-field"]])
def test_a_batch_is_many_fresh_programs(options: list[str]) -> None:
    count = 8
    wanted, tails = demands(count), np.random.default_rng(SEED).uniform(-3, 3, (count, 3))
    names = {"--loss-tolerant": "loss_tolerant", "--planner": "planner"}
    chosen: dict[str, Any] = {names[key]: value for key, value in zip(options[::2], options[1::2], strict=True)}
    planner = flotilla.Planner(ROW, **chosen)
    for angles in [None, tails]:
        plans = planner.batch(wanted, angles)
        again = planner.batch(wanted, angles, threads=3)
        for index in range(count):
            tail = None if angles is None else angles[index].tolist()
            request = {"cells": ROW, "demand": demand(wanted[index]), "tail_rad": tail}
            [answer] = answers(["plan", *options], [request])
            alone = flotilla.plan(ROW, wanted[index], tail, **chosen)
            assert timeless(alone.to_dict()) == timeless(answer)
            assert ["planned", "repeated", "held"][plans.outcome[index]] == answer["outcome"]
            np.testing.assert_array_equal(plans.centerline_rad[index], columns(answer, "cycle.centerline_rad"))
            np.testing.assert_array_equal(plans.amplitude_rad[index], columns(answer, "cycle.amplitude_rad"))
            assert plans.wrench[index].tolist() == list(answer["wrench"].values())
            assert plans.travel_rad[index] == answer["travel_rad"]
            assert plans.loss_tolerant[index] == answer["loss_tolerant"]
        for name in ["centerline_rad", "amplitude_rad", "from_rad", "via_rad", "to_rad", "error", "clearance_m", "guarantee_m"]:
            np.testing.assert_array_equal(getattr(plans, name), getattr(again, name))


def test_an_envelope() -> None:
    wanted = np.vstack([demands(20), [[0, 0, 0], [0, 0, 0.02]]])
    for cells in [ROW, SQUARE, [[0, 0]]]:
        requests = [{"cells": cells, "demand": demand(row)} for row in wanted]
        expected = answers(["plan", "--envelope"], requests)
        envelope = flotilla.envelope(cells)
        gauge, inside, boundary = envelope.gauge(wanted), envelope.inside(wanted), envelope.boundary(wanted)
        for index, answer in enumerate(expected):
            assert envelope.locate(wanted[index]) == answer
            assert gauge[index] == (np.inf if answer["gauge"] is None else answer["gauge"])
            assert inside[index] == answer["inside"]
            if answer["boundary"] is None:
                assert np.isnan(boundary[index]).all()
            else:
                assert boundary[index].tolist() == list(answer["boundary"].values())
            assert envelope.extremes.tolist() == list(answer["extremes"].values())


def test_a_transition_is_that_of_the_plan() -> None:
    # The potential field's transitions are those of this very question.
    rng = np.random.default_rng(SEED)
    met = 0
    for row in demands(20):
        tails = rng.uniform(-3, 3, 4)
        request = {"cells": SQUARE, "demand": demand(row), "tail_rad": tails.tolist()}
        [answer] = answers(["plan", "--planner", "potential-field"], [request])
        if answer["outcome"] != "planned" or answer["transition"] is None:
            continue
        swings = columns(answer, "cycle.centerline_rad"), columns(answer, "cycle.amplitude_rad")
        found = flotilla.transition(SQUARE, tails, *swings, planner="potential-field")
        assert found is not None and not found.negated
        np.testing.assert_array_equal(found.from_rad, tails)
        np.testing.assert_array_equal(found.to_rad, columns(answer, "transition.to_rad"))
        # Summed in another order.
        assert abs(found.travel_rad - answer["travel_rad"]) < 1e-14
        met += 1
    assert met > 10


@pytest.mark.parametrize("vehicle", ["bluerov1", "bluerov2"])
def test_motion_of_an_rov(vehicle: str) -> None:
    at_s = [0.5, 2.0, 1.0]
    start = {"eta": [0.1, 0.2, 0.3, 0.05, -0.1, 2.0], "nu": [0.3, 0.0, -0.1, 0.0, 0.2, 0.1]}
    thrusters = flotilla.RovSimulation(vehicle).thrusters
    pushes: list[dict[str, Any]] = [
        {"tau": [10.0, -2.0, 3.0, 0.1, 0.2, 1.0]},
        {"pwm_us": [1700.0, 1300.0, 1600.0, 1450.0, 1500.0, 1550.0][:thrusters], "voltage_v": 15.3},
    ]
    for push in pushes:
        [answer] = answers(["simulate", vehicle], [{**start, **push, "at_s": at_s}])
        eta, nu = flotilla.simulate(vehicle, at_s, **start, **push)
        assert eta.tolist() == [state["eta"] for state in answer["states"]]
        assert nu.tolist() == [state["nu"] for state in answer["states"]]
        # A described body moves as the named one does.
        if "tau" in push:
            described, _ = flotilla.simulate(flotilla.vehicle(vehicle), at_s, **start, **push)
            np.testing.assert_array_equal(described, eta)
        # A step is such a motion, whatever number of them and of threads.
        many = flotilla.RovSimulation(vehicle, 3, **start)
        many.step(2.0, **push, threads=2)
        for row in range(3):
            np.testing.assert_array_equal(many.eta[row], eta[1])
            np.testing.assert_array_equal(many.nu[row], nu[1])


def test_a_run_and_its_log(tmp_path: Path) -> None:
    program("run", "holonomic-1", "--seed", 7, "--out", tmp_path / "program")
    run = flotilla.run("holonomic-1", seed=7, log=tmp_path / "log.mcap")
    summary = json.loads((tmp_path / "program" / "summary.json").read_text())
    assert timeless(run.summary) == timeless(summary)
    assert run.complaints == []
    logs = [flotilla.read_log(tmp_path / "program" / "log.mcap"), flotilla.read_log(tmp_path / "log.mcap")]
    assert logs[0].whole and list(logs[0]) == list(logs[1])
    assert {"/fix", "/decision", "/tails"} <= set(logs[0])
    for topic, table in logs[0].items():
        for name, column in table.items():
            if not is_time(name) and topic not in ("/summary", "/end"):
                np.testing.assert_array_equal(column, logs[1][topic][name], err_msg=f"{topic} {name}")


def test_a_log_is_what_export_writes(tmp_path: Path) -> None:
    log = tmp_path / "log.mcap"
    flotilla.run("station-keeping", seed=3, log=log)
    program("export", log, "--csv", tmp_path / "tables")
    topics = flotilla.read_log(log)
    files = {file.stem: file for file in (tmp_path / "tables").iterdir()}
    assert {topic.strip("/").replace("/", "_") for topic in topics} == set(files)
    kinds = set()
    for topic, table in topics.items():
        with files[topic.strip("/").replace("/", "_")].open(newline="") as file:
            header, *rows = list(csv.reader(file))
        # A name that comes twice is told apart as pandas tells it.
        header = [name if name not in header[:place] else f"{name}.1" for place, name in enumerate(header)]
        assert list(table) == header
        for place, (name, column) in enumerate(table.items()):
            cells = [row[place] for row in rows]
            assert len(column) == len(cells), (topic, name)
            kinds.add(column.dtype.kind)
            for value, cell in zip(column.tolist(), cells, strict=True):
                assert same(value, cell, column.dtype), (topic, name, value, cell)
        frame = topics.frame(topic)
        assert list(frame.columns) == header and len(frame) == len(rows)
    assert kinds >= {"f", "u", "U"}, kinds
    one = flotilla.read_log(log, ["/fix"])
    assert list(one) == ["/fix"]
    np.testing.assert_array_equal(one["/fix"]["t_s"], topics["/fix"]["t_s"])


def same(value: Any, cell: str, kind: np.dtype[Any]) -> bool:
    """Whether a value is what stands in a cell."""
    if isinstance(value, bool):
        return str(value).lower() == cell
    if isinstance(value, str):
        return value == cell
    if cell == "":
        return bool(np.isnan(value))
    number = {"true": 1.0, "false": 0.0}.get(cell)
    if number is None:
        number = np.float32(cell).item() if kind == np.float32 else type(value)(cell)
    return value == number or (np.isnan(value) and np.isnan(number))


@pytest.mark.parametrize(
    "options", [{"criterion": "energy"}, {"criterion": "euclidean", "manner": "paper"}, {"parallel": "time"}]
)
def test_a_reconfiguration(options: dict[str, Any], tmp_path: Path) -> None:
    chosen = {"criterion": "energy", **options}
    words = [word for key, value in chosen.items() for word in (f"--{key}", value)]
    answer = json.loads(program("reconfigure", "t-to-i-far", *words, "--json"))
    found = flotilla.reconfigure("t-to-i-far", **chosen)
    assert timeless(found.to_dict()) == timeless(answer)
    assert (found.energy_total_j, found.time_s) == (answer["energy_total_j"], answer["time_s"])
    assert found.summary is None


def test_an_executed_reconfiguration(tmp_path: Path) -> None:
    words = ["--criterion", "energy", "--manner", "paper", "--seed", 4]
    program("reconfigure", "t-to-i-far", *words, "--out", tmp_path)
    [summary] = json.loads((tmp_path / "summary.json").read_text()).values()
    found = flotilla.reconfigure("t-to-i-far", criterion="energy", manner="paper", seed=4, execute=True)
    assert found.summary is not None and timeless(found.summary) == timeless(summary)


@pytest.mark.parametrize("algorithm", ["theta", "basic-theta", "a-star", "a-star-smoothed"])
def test_routes(algorithm: Any, tmp_path: Path) -> None:
    rng = np.random.default_rng(SEED)
    blocked = rng.random((24, 31)) < 0.3
    file = tmp_path / "small.map"
    rows = ["".join("@" if cell else "." for cell in row) for row in blocked]
    file.write_text("\n".join(["type octile", "height 24", "width 31", "map", *rows]) + "\n")
    solid = rng.random((5, 6, 7)) < 0.3
    voxels = tmp_path / "small.3dmap"
    cells = [f"{x} {y} {z}" for z, y, x in zip(*np.nonzero(solid), strict=True)]
    voxels.write_text("\n".join(["voxel 7 6 5", *cells]) + "\n")
    found = 0
    for path, array, limits in [(file, blocked, (31, 24)), (voxels, solid, (7, 6, 5))]:
        maps = [flotilla.Map(path), flotilla.Map(array)]
        for _ in range(8):
            start, goal = ([int(rng.integers(limit)) for limit in limits] for _ in range(2))
            ends = [",".join(map(str, place)) for place in (start, goal)]
            words = ["--from", ends[0], "--to", ends[1], "--algorithm", algorithm, "--json"]
            answer = json.loads(program("path", path, *words))
            for map_ in maps:
                route = map_.route(start, goal, algorithm=algorithm)
                assert timeless(route.to_dict()) == timeless(answer)
                assert route.length == answer["length"]
                assert (None if route.path is None else route.path.tolist()) == answer["path"]
            found += answer["path"] is not None
        assert flotilla.route(path, start, goal, algorithm=algorithm).length == answer["length"]
    assert found > 4


def test_identified_constants(tmp_path: Path) -> None:
    log = tmp_path / "log.mcap"
    flotilla.run("identify-3", seed=5, log=log)
    answer = json.loads(program("identify", log, "--json", "--out", tmp_path))
    found = flotilla.identify([log])
    assert found.to_dict() == answer
    assert found.to_toml() == (tmp_path / "identified.toml").read_text()
    constant = answer["constants"][0]
    assert found.constant(constant["name"]) == (constant["value"], constant["low"], constant["high"])


def test_the_programs_own_scenarios_are_taken() -> None:
    request = {"cells": ROW, "demand": demand([0.02, 0.0, 0.0]), "tail_rad": None}
    scenario = TOP / "host" / "scenarios" / "holonomic-2.toml"
    [answer] = answers(["plan", "--scenario", scenario], [request])
    assert timeless(flotilla.plan(ROW, [0.02, 0, 0], scenario=str(scenario)).to_dict()) == timeless(answer)
