"""A batch of 10,000 plans from numpy against the same loop in Rust.

    host/python/bench/run

Both take turns on the same machine, on one thread each, and what that thread had of a processor is measured. Medians and their ratio are
printed; the sums of all errors show that both planned the same.
"""

import subprocess
import sys
import tempfile
import time
from statistics import median

import numpy as np

import flotilla

COUNT = 10_000
ROUNDS = 5
SHAPES = {"3x1": [[x, 0] for x in range(3)], "3x3": [[x, y] for y in range(3) for x in range(3)]}


def compare(program: str, shape: str) -> float:
    """Time from Python over time in Rust, ratio of medians."""
    cells = SHAPES[shape]
    demands = np.random.default_rng(20).uniform(-1, 1, (COUNT, 3)) * [0.02, 0.02, 0.002] * len(cells) / 3
    planner = flotilla.Planner(cells)
    python, rust = [], []
    with tempfile.NamedTemporaryFile() as file:
        file.write(demands.tobytes())
        file.flush()
        command = [program, shape, file.name]
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as loop:
            assert loop.stdin is not None and loop.stdout is not None
            for _ in range(ROUNDS + 1):
                began = time.thread_time()
                plans = planner.batch(demands)
                # What a user reads.
                arrays = plans.centerline_rad, plans.amplitude_rad, plans.wrench, plans.error
                python.append(time.thread_time() - began)
                loop.stdin.write("\n")
                loop.stdin.flush()
                seconds, errors = loop.stdout.readline().split()
                rust.append(float(seconds))
                # Summed in another order.
                assert abs(arrays[3].sum() - float(errors)) <= 1e-9 * COUNT, (arrays[3].sum(), errors)
    # The first warms both.
    from_python, in_rust = median(python[1:]), median(rust[1:])
    ratio = from_python / in_rust
    print(
        f"{shape}: {COUNT} plans from numpy {from_python * 1e3:.1f} ms, in Rust {in_rust * 1e3:.1f} ms: {ratio:.3f} "
        f"(medians of {ROUNDS})"
    )
    return ratio


if __name__ == "__main__":
    for name in SHAPES:
        compare(sys.argv[1], name)
