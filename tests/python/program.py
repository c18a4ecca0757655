"""The program that the package is compared with."""

import json
import os
import subprocess
from collections.abc import Iterable
from pathlib import Path
from typing import Any

PROGRAM = os.environ["FLOTILLA_PROGRAM"]
TOP = Path(__file__).parents[2]

#: Figures that are times of the computer, and differ from run to run.
TIMES = {"time_us"}


def flotilla(*arguments: object, lines: str | None = None, fails: bool = False) -> str:
    """What the program prints."""
    command = [PROGRAM, *map(str, arguments)]
    done = subprocess.run(command, input=lines, capture_output=True, text=True, check=False)
    assert fails or done.returncode == 0, f"{command}: {done.returncode}\n{done.stderr}"
    return done.stdout


def answers(command: list[object], requests: Iterable[Any], fails: bool = False) -> list[Any]:
    """What a filter answers to these requests, in one process."""
    lines = "".join(json.dumps(request) + "\n" for request in requests)
    return [json.loads(line) for line in flotilla(*command, lines=lines, fails=fails).splitlines()]


def timeless(value: Any) -> Any:
    """The same without times of the computer."""
    if isinstance(value, dict):
        return {key: timeless(inner) for key, inner in value.items() if not is_time(key)}
    if isinstance(value, list):
        return [timeless(inner) for inner in value]
    return value


def is_time(key: str) -> bool:
    """Whether a figure is a time of the computer."""
    return key in TIMES or any(word in key for word in ("solve", "wall", "unix"))
