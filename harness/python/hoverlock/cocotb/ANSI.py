"""``cocotb.ANSI``: escape sequences for colours, by cocotb 1's names."""

from typing import Any

from .log import ANSI as _ANSI


def __getattr__(name: str) -> Any:
    # cocotb 1 has DEFAULT and the colours without a suffix for the ground.
    return getattr(_ANSI, name)
