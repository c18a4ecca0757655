"""The stubs: strict, as the module is, and of use."""

import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent


def said(*words: str) -> str:
    done = subprocess.run([sys.executable, "-m", *words], cwd=HERE, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture
def settings(tmp_path: Path) -> str:
    """mypy's own settings, with its cache elsewhere."""
    file = tmp_path / "mypy.ini"
    file.write_text(
        f"[mypy]\nstrict = True\ncache_dir = {tmp_path / 'cache'}\n"
        "[mypy-pettingzoo.*]\nfollow_untyped_imports = True\n"
    )
    return str(file)


def test_the_package_is_strict(settings: str) -> None:
    assert "Success" in said("mypy", "--config-file", settings, "--package", "flotilla")


def test_what_uses_it_is_strict(settings: str) -> None:
    assert "Success" in said("mypy", "--config-file", settings, "typed.py", "program.py", "test_types.py")


def test_the_stubs_are_of_this_module(settings: str) -> None:
    said("mypy.stubtest", "--mypy-config-file", settings, "flotilla._flotilla", "flotilla._log")


def test_wrong_use_is_found(settings: str, tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.py"
    wrong.write_text('import flotilla\nplan: int = flotilla.plan([[0, 0]], [0.0] * 3, planner="best")\n')
    command = [sys.executable, "-m", "mypy", "--config-file", settings, str(wrong)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 1 and done.stdout.count("error:") == 2, done.stdout
