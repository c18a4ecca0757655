"""Steps a second of 256 environments from Python and in Rust, and of one in numpy.

    host/python/bench/run environments

Python and Rust take turns on the same machine, each on all cores; numpy is the reference that the tests carry, one environment on one
core, without and with its contacts. Medians of short rounds and their ratios are printed, and the ratio of the time that processors
spent, which depends less on what else goes on.
"""

import os
import subprocess
import sys
import time
from pathlib import Path
from statistics import median

import numpy as np
from numpy.typing import NDArray

from flotilla.environments import FlotillaVectorEnv

sys.path.insert(0, str(Path(__file__).parents[3] / "tests" / "python"))
from environment_reference import Reference

ENVIRONMENTS = 256


def python_seconds(env: FlotillaVectorEnv, actions: list[NDArray[np.float64]], steps: int) -> float:
    """How long so many steps of all take."""
    began = time.perf_counter()
    for step in range(steps):
        env.step(actions[step % len(actions)])
    return time.perf_counter() - began


def numpy_seconds(steps: int, *, contacts: bool) -> tuple[float, float]:
    """How long a step of the reference takes, and how much of its processor's time."""
    reference = Reference(
        positions_m=np.array([[-0.15, 0.0], [0.0, 0.0], [0.15, 0.0]]),
        position_m=np.zeros(2),
        heading_rad=0.3,
        velocity_m_s=np.array([0.02, 0.01]),
    )
    if not contacts:
        reference.pairs = reference.pairs[:0]
    actions = np.random.default_rng(1).uniform(-1, 1, (steps, 9)) * np.tile([np.pi, 2.6, 1.0], 3)
    began, spent = time.perf_counter(), time.process_time()
    for action in actions:
        reference.step(action)
    return (time.perf_counter() - began) / steps, (time.process_time() - spent) / steps


def spent_s(process: int) -> float:
    """What a process has spent of its processors' time, s, by Linux."""
    after_name = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(after_name[11]) + int(after_name[12])) / os.sysconf("SC_CLK_TCK")


def compare(program: str, fidelity: str, steps: int, rounds: int) -> None:
    """Prints the rates of one fidelity."""
    env = FlotillaVectorEnv(ENVIRONMENTS, fidelity=fidelity, scenario="holonomic-1")
    env.reset(seed=0)
    env.action_space.seed(1)
    actions = [env.action_space.sample() for _ in range(8)]
    seconds: dict[str, list[float]] = {"python": [], "rust": []}
    numpy: dict[bool, list[tuple[float, float]]] = {False: [], True: []}
    from_python_s = 0.0
    command = [program, "serve", fidelity]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as loop:
        assert loop.stdin is not None and loop.stdout is not None
        for round_ in range(rounds + 1):
            if round_ == 1:
                # The first has warmed both.
                in_rust_s = spent_s(loop.pid)
            began = time.process_time()
            seconds["python"].append(python_seconds(env, actions, steps))
            from_python_s += (time.process_time() - began) if round_ > 0 else 0.0
            loop.stdin.write(f"{steps}\n")
            loop.stdin.flush()
            seconds["rust"].append(float(loop.stdout.readline()))
            if fidelity == "cycle":
                for contacts, each in numpy.items():
                    each.append(numpy_seconds(10, contacts=contacts))
        in_rust_s = spent_s(loop.pid) - in_rust_s
    rate = {name: steps * ENVIRONMENTS / median(all_[1:]) for name, all_ in seconds.items()}
    ratio, effort = rate["python"] / rate["rust"], in_rust_s / from_python_s
    print(
        f"{fidelity}: {rate['python']:.0f} steps/s from Python, {rate['rust']:.0f} in Rust: {ratio:.3f} "
        f"(medians of {rounds}); by processors' time {effort:.3f}"
    )
    cores = len(os.sched_getaffinity(0))
    done = steps * ENVIRONMENTS * rounds
    for contacts, each in numpy.items():
        if each:
            slow_s, slow_spent_s = (median(times) for times in zip(*each[1:], strict=True))
            what = "with contacts" if contacts else "without contacts"
            print(
                f"{fidelity}: {1 / slow_s:.0f} steps/s in numpy {what}: {rate['python'] * slow_s:.0f} times as many from Python; "
                f"by processors' time {done / from_python_s * slow_spent_s:.0f} on each of {cores} cores"
            )


if __name__ == "__main__":
    compare(sys.argv[1], "cycle", steps=40, rounds=201)
    compare(sys.argv[1], "module", steps=1, rounds=9)
