"""The tutorial works as written: its files are written, its commands run, and what it shows is seen."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[3]
TUTORIAL = PROJECT / "harness" / "docs" / "tutorial-python.md"
BLOCK = re.compile(r"^```(\w+)(?: (\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def follow(folder, *, install):
    """Does what the tutorial says, as a newcomer: the first commands install the module into a venv, or are left out."""
    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}
    environment.pop("VIRTUAL_ENV", None)
    before = f'export PATH="{Path(sys.executable).parent}:$PATH"\n'
    ran = 0
    for language, name, text in BLOCK.findall(TUTORIAL.read_text()):
        assert name or language == "console", f"a block of the tutorial is neither a file nor commands:\n{text}"
        if name:
            (folder / name).write_text(text)
            continue
        commands = [line[2:] for line in text.splitlines() if line.startswith("$ ")]
        shown = [line for line in text.splitlines() if not line.startswith("$ ")]
        if ran == 0 and "pip install" in text:
            if not install:
                ran += 1
                continue
            before = ""
        script = before + "\n".join(commands).replace("PROJECT", str(PROJECT))
        done = subprocess.run(
            ["bash", "-ec", script], cwd=folder, env=environment, capture_output=True, text=True, timeout=900
        )
        said = done.stdout + done.stderr
        assert done.returncode == (1 if any("failed" in s for s in shown) else 0), f"{script}\n{said}"
        for line in shown:
            assert line in said, f"{script}\ndoes not show '{line}':\n{said}"
        if install and not before:
            before = ". .venv/bin/activate\n"
        ran += 1
    return ran


def test_the_tutorial_works(tmp_path):
    assert follow(tmp_path, install=False) == 9


@pytest.mark.skipif(
    "HOVERLOCK_TEST_INSTALL" not in os.environ,
    reason="the install of the tutorial is not tested (it takes minutes and the network); to test it: "
    "HOVERLOCK_TEST_INSTALL=1 pytest harness/python/tests/test_tutorial.py",
)
def test_the_tutorial_works_in_a_fresh_venv(tmp_path):
    assert follow(tmp_path, install=True) == 9
