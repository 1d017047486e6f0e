"""Digits that a signal cannot have, such as ``X`` and ``Z``: an error, unless a bench chooses a replacement.

>>> with hoverlock.unknown.written_as("random"):
...     dut.data.value = "XXXX0000"
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Literal, get_args

__all__ = ["set_choice", "written_as"]

Choice = Literal["error", "weak", "zeros", "ones", "random"]
"""The replacement of a digit that is neither 0 nor 1."""

_choice: Choice = "error"
# The signals of this run for which a warning was logged.
_warned: set[str] = set()


def set_choice(choice: Choice) -> None:
    """Sets the replacement of such digits from now on: ``"error"``, ``"zeros"``, ``"ones"``, or ``"random"``, which
    draws from the test's ``random``. All but ``"error"`` replace ``L`` by 0 and ``H`` by 1; with ``"weak"`` any other is an error.

    Raises
    ------
    ValueError
        If there is no such choice.

    >>> set_choice("zeros")
    """
    global _choice
    if choice not in get_args(Choice):
        raise ValueError(f"no choice '{choice}': {', '.join(get_args(Choice))}")
    _choice = choice


@contextmanager
def written_as(choice: Choice) -> Iterator[None]:
    """Sets the replacement for the statements inside the ``with`` block.

    >>> with written_as("random"):
    ...     dut.data.value = LogicArray("XXXX0000")
    """
    before = _choice
    set_choice(choice)
    try:
        yield
    finally:
        set_choice(before)


def resolve(name: str, digits: str) -> str:
    """Replaces all digits other than 0 and 1; logs a warning once for each signal of a run."""
    weak = digits.translate(str.maketrans("lhLH", "0101"))
    if _choice == "error" or (_choice == "weak" and weak.strip("01")):
        raise ValueError(
            f"'{digits}' is not a value of '{name}': a signal has digits 0 and 1 only (Verilator has no X and no Z); "
            "hoverlock.unknown.set_choice('zeros') or 'random' selects a replacement"
        )
    if name not in _warned:
        _warned.add(name)
        from .log import log

        log.getChild("harness").warning("'%s' was given '%s': digits other than 0 and 1 are written as %s", name, digits, _choice)
    if _choice == "random":
        return "".join(digit if digit in "01" else random.choice("01") for digit in weak)
    return "".join(digit if digit in "01" else "0" if _choice == "zeros" else "1" for digit in weak)


def begin() -> None:
    """Begins a run: each signal is warned of again."""
    _warned.clear()
