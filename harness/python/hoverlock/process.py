"""Runs the command line in a process of its own, for the runner and for cocotb-test.

>>> status = run_command(["--as-cocotb", "test_adder"], folder="sim_build")
"""

from __future__ import annotations

import logging
import os
import shlex
import subprocess
import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING
from xml.etree import ElementTree

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["failures_in", "run_command"]

log = logging.getLogger("cocotb")

# Seconds after a run was asked to end until it is killed.
_END_S = 5.0


def run_command(arguments: Sequence[str], *, folder: str | Path, environment: Mapping[str, str] | None = None) -> int:
    """Runs ``python -m hoverlock`` in a folder, prints what it prints, and returns its exit status. The process finds the
    modules that this one finds.

    >>> run_command(["--as-cocotb", "test_adder"], folder="sim_build")
    """
    command = [sys.executable, "-m", "hoverlock", *arguments]
    log.info("runs %s", shlex.join(command))
    process = subprocess.Popen(
        command, cwd=folder, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), **(environment or {})},
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
    )  # fmt: skip
    try:
        assert process.stdout is not None
        for line in process.stdout:
            print(line, end="")
        return process.wait()
    except BaseException:
        process.terminate()
        try:
            process.wait(_END_S)
        except subprocess.TimeoutExpired:
            process.kill()
        raise


def failures_in(results: str | Path) -> list[str]:
    """Returns the names of the failed tests in a results file.

    >>> assert failures_in("results.xml") == []
    """
    return [
        f"{case.get('classname')}.{case.get('name')}"
        for case in ElementTree.parse(results).iter("testcase")
        if case.find("failure") is not None or case.find("error") is not None
    ]
