"""The tutorial works as it stands: its files are written, its commands run, and what it shows is seen."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HARNESS = Path(__file__).resolve().parents[2]
TUTORIAL = HARNESS / "docs" / "tutorial.md"
BLOCK = re.compile(r"^```(\w+)(?: (\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def follow(folder, program):
    """Does what the tutorial says, of the commands only those of one program's language."""
    environment = {
        **os.environ,
        "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
        "PYTHONDONTWRITEBYTECODE": "1",
        "CARGO_NET_OFFLINE": "true",
    }
    ran = 0
    for language, name, text in BLOCK.findall(TUTORIAL.read_text()):
        if name:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(text.replace('"HARNESS"', f'"{HARNESS}"'))
        elif language == "console":
            commands = [line[2:] for line in text.splitlines() if line.startswith("$ ")]
            shown = [line for line in text.splitlines() if not line.startswith("$ ")]
            if commands[0].startswith("cargo") != (program == "cargo"):
                continue
            for command in commands:
                done = subprocess.run(
                    command, shell=True, cwd=folder, env=environment, capture_output=True, text=True, timeout=900
                )
                said = done.stdout + done.stderr
                assert done.returncode == (1 if any("failed" in s for s in shown) else 0), f"{command}\n{said}"
                ran += 1
            for line in shown:
                assert line in said, f"{command} does not show '{line}':\n{said}"
    return ran


def test_the_tutorial_works_from_python(tmp_path):
    assert follow(tmp_path, "python") == 7


@pytest.mark.skipif(shutil.which("cargo") is None, reason="cargo is not on the PATH")
def test_the_tutorial_works_from_rust(tmp_path, monkeypatch):
    workspace = HARNESS.parent
    shutil.copy(workspace / "Cargo.lock", tmp_path)
    # What the workspace has compiled need not be compiled again.
    monkeypatch.setenv("CARGO_TARGET_DIR", os.environ.get("CARGO_TARGET_DIR", str(workspace / "target")))
    assert follow(tmp_path, "cargo") == 2
