"""Options and report of ``Session.transfer``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal, NamedTuple, TypeAlias

__all__ = ["Pause", "TransferOptions", "TransferReport"]

Pause: TypeAlias = "float | Iterable[bool] | None"
"""The cycles in which a bus model pauses: a probability, a repeated pattern, or None for never."""


class TransferReport(NamedTuple):
    """The counts of a transfer.

    Attributes
    ----------
    cycles : int
        Clock cycles of the transfer.
    sent : int
        Beats that the design accepted.
    received : int
        Beats received from the design.
    packets : int
        Packets received from the design.

    >>> received = session.transfer(samples)
    >>> session.report.cycles / session.report.sent
    """

    cycles: int
    sent: int
    received: int
    packets: int


class TransferOptions(NamedTuple):
    """The arguments of ``Session.transfer`` for the engine; the parameters are explained there. The period is in femtoseconds."""

    # The streams.
    input: str
    output: str
    bus: Literal["avalon", "axi"]
    ready_latency: int
    clock: str
    period: int
    # The pauses.
    idle: Pause
    stall: Pause
    seed: int
    # The packets, and the end.
    packet: int
    expect: int | None
    packets: int
    most_cycles: int
