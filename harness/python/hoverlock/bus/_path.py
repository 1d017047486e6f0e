"""Names of a bus's signals."""

from __future__ import annotations

from typing import Any


def below(dut: Any, prefix: str) -> str:
    """Returns the path of the signals that begin with `prefix` in the design or in an instance of it."""
    path = getattr(dut, "_below", "")
    return f"{path}.{prefix}" if path else prefix
