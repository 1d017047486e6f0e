"""Kinds of writes: what a bench assigns to ``value`` in place of a plain value.

>>> dut.u_core.enable.value = Force(1)
"""

from __future__ import annotations

from typing import Any

__all__ = ["Deposit", "Force", "Freeze", "Immediate", "Release", "deposits_on_outputs", "set_deposits_on_outputs"]

_deposits_on_outputs = False


def set_deposits_on_outputs(yes: bool) -> None:
    """Sets whether a write to an output of the top is a deposit, from the next simulation on: the output has the value
    written until the design assigns it again, and a warning is logged once for each signal. Without it, such a write raises
    `NotWritable`.

    >>> set_deposits_on_outputs(True)
    """
    global _deposits_on_outputs
    _deposits_on_outputs = yes


def deposits_on_outputs() -> bool:
    """Returns whether a write to an output of the top is a deposit."""
    return _deposits_on_outputs


class Deposit:
    """A plain write.

    >>> dut.data.value = Deposit(5)
    """

    def __init__(self, value: Any) -> None:
        self.value = value

    @property
    def _deposited(self) -> Any:
        return self.value

    def __index__(self) -> int:
        return int(self.value, 2) if isinstance(self.value, str) else int(self.value.__index__())


class Immediate(Deposit):
    """A plain write: there are no delta cycles here.

    >>> dut.data.value = Immediate(5)
    """


class Force:
    """A value that overrides the design's assignments, for the design and for the bench, until ``Release``.

    The signal is one of ``Design(..., forceable=[...])``, or some bits of it. On an input of the top, which the bench
    alone drives, it is a plain write.

    >>> dut.u_core.enable.value = Force(1)
    >>> dut.u_core.state[3].value = Force(0)
    """

    _change = "force"

    def __init__(self, value: Any) -> None:
        self.value = value

    def __repr__(self) -> str:
        return f"Force({self.value!r})"


class Freeze:
    """A ``Force`` of the value that the signal has now.

    >>> dut.u_core.enable.value = Freeze()
    """

    _change = "freeze"

    def __repr__(self) -> str:
        return "Freeze()"


class Release:
    """The end of a ``Force`` or ``Freeze``: the signal has the value that the design assigns.

    >>> dut.u_core.enable.value = Release()
    """

    _change = "release"

    def __repr__(self) -> str:
        return "Release()"
