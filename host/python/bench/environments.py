"""Steps a second of learning environments: 256 from Python, the same from Rust, one in numpy.

    cargo bench -p environment --no-run
    python host/python/bench/environments.py target/release/deps/rate-…

Python and Rust take turns on the same machine; medians and their ratios are printed. Without the Rust program its part is left out.
"""

import re
import subprocess
import sys
import time
from pathlib import Path
from statistics import median

import numpy as np

from flotilla.environments import FlotillaVectorEnv

sys.path.insert(0, str(Path(__file__).parents[3] / "tests" / "python"))
from environment_reference import Reference  # noqa: E402

ENVIRONMENTS = 256
ROUNDS = 5


def python_rate(env: FlotillaVectorEnv, steps: int) -> float:
    """Steps a second of one round."""
    actions = [env.action_space.sample() for _ in range(8)]
    began = time.perf_counter()
    for step in range(steps):
        env.step(actions[step % len(actions)])
    return steps * ENVIRONMENTS / (time.perf_counter() - began)


def rust_rate(program: str, fidelity: str) -> float:
    """Steps a second on all cores, by the program of `cargo bench`."""
    said = subprocess.run([program, fidelity], check=True, capture_output=True, text=True).stdout
    found = re.search(rf"^{fidelity} .*?(\d+) on all cores", said, re.MULTILINE)
    if found is None:
        raise RuntimeError(f"{program} said: {said}")
    return float(found[1])


def numpy_rate(steps: int) -> float:
    """Steps a second of the reference that the tests carry."""
    reference = Reference(
        positions_m=np.array([[-0.15, 0.0], [0.0, 0.0], [0.15, 0.0]]),
        position_m=np.zeros(2),
        heading_rad=0.3,
        velocity_m_s=np.array([0.02, 0.01]),
    )
    actions = np.random.default_rng(1).uniform(-1, 1, (steps, 9)) * np.tile([np.pi, 2.6, 1.0], 3)
    began = time.perf_counter()
    for action in actions:
        reference.step(action)
    return steps / (time.perf_counter() - began)


def main() -> None:
    """Prints the table."""
    program = sys.argv[1] if len(sys.argv) > 1 else None
    for fidelity, steps in [("cycle", 400), ("module", 2)]:
        env = FlotillaVectorEnv(ENVIRONMENTS, fidelity=fidelity, scenario="holonomic-1")
        env.reset(seed=1)
        env.action_space.seed(1)
        rates: dict[str, list[float]] = {"python": [], "rust": [], "numpy": []}
        for _ in range(ROUNDS):
            rates["python"].append(python_rate(env, steps))
            if program is not None:
                rates["rust"].append(rust_rate(program, fidelity))
            if fidelity == "cycle":
                rates["numpy"].append(numpy_rate(200))
        middle = {name: median(all_) for name, all_ in rates.items() if all_}
        for name, rate in middle.items():
            print(f"{fidelity:<7} {name:<7} {rate:>12.0f} steps/s   python × {middle['python'] / rate:.3g}")


if __name__ == "__main__":
    main()
