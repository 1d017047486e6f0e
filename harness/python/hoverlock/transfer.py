"""Options and report of ``Session.transfer``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal, NamedTuple, TypeAlias

__all__ = ["Pause", "TransferOptions", "TransferReport"]

Pause: TypeAlias = "float | Iterable[bool] | None"
"""In which cycles a bus model pauses: a probability, a repeated pattern, or never."""


class TransferReport(NamedTuple):
    """How a transfer went.

    Attributes
    ----------
    cycles : int
        Clock cycles it took.
    sent : int
        Beats the design took.
    received : int
        Beats the design gave.
    packets : int
        Packets the design gave.

    >>> received = session.transfer(samples)
    >>> session.report.cycles / session.report.sent
    """

    cycles: int
    sent: int
    received: int
    packets: int


class TransferOptions(NamedTuple):
    """What ``Session.transfer`` hands to the engine; the parameters are explained there. Its period is in femtoseconds."""

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
