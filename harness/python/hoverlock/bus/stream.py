"""Avalon-ST and AXI4-Stream: sources, sinks and monitors."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._core import Handle
from ..triggers import Trigger
from ._path import below

if TYPE_CHECKING:
    from ..transfer import Pause

__all__ = ["AvalonMonitor", "AvalonSink", "AvalonSource", "AxiMonitor", "AxiSink", "AxiSource", "Frame"]


@dataclass
class Frame:
    """A packet: its symbols, channel and error.

    >>> source.send(Frame(np.arange(10, dtype=np.uint8), channel=2))
    """

    symbols: Any
    """Symbols in the order of the stream. Received: a ``uint64`` array of shape (symbols,). Sent: any iterable of integers."""
    channel: int = 0
    """``channel`` of Avalon-ST, ``tid`` of AXI4-Stream."""
    error: int = 0
    """``error`` (``tuser``) of the last beat."""
    destination: int = 0
    """``tdest`` of AXI4-Stream."""

    def __bytes__(self) -> bytes:
        return bytes(int(s) for s in self.symbols)

    def __len__(self) -> int:
        return len(self.symbols)


class _Source:
    """The driver of a stream into the design."""

    _bus = ""

    def __init__(
        self,
        dut: Any,
        prefix: str,
        clock: Handle,
        *,
        reset: Handle | None = None,
        reset_active: bool = True,
        ready_latency: int = 0,
        symbol_bits: int | None = None,
    ) -> None:
        self._raw = _core.RawSource(
            below(dut, prefix), clock, self._bus, ready_latency, symbol_bits, reset, reset_active
        )

    def send(self, frame: Frame | bytes | Iterable[int], *, channel: int = 0, error: int = 0) -> None:
        """Queues a packet.

        Parameters
        ----------
        frame : Frame, bytes or iterable of int
            The packet, or its symbols, such as an array.
        channel, error : int
            ``channel`` (``tid``) and ``error`` (``tuser``), unless a ``Frame`` is given.

        Raises
        ------
        HoverlockError
            If the packet is empty, a symbol, channel or error does not fit, or the last beat is not full and there is
            neither ``empty`` nor ``tkeep`` to mark it.
        """
        if isinstance(frame, Frame):
            self._raw.send(frame.symbols, frame.channel, frame.error, frame.destination)
        else:
            self._raw.send(list(frame), channel, error, 0)

    def pause(self, pause: Pause, seed: int = 0) -> None:
        """Sets the cycles in which the source offers no new beat.

        Parameters
        ----------
        pause : float or iterable of bool, optional
            A probability from 0 to less than 1, or a pattern (true: pause) that is repeated; None: never.
        seed : int
            Seed of the random numbers.

        Raises
        ------
        ValueError
            If the probability is out of range, or the pattern lets nothing through.
        """
        self._raw.set_pause(pause, seed)

    def clear(self) -> None:
        """Discards everything queued. A reset discards only the rest of the packet in progress."""
        self._raw.clear()

    def drained(self) -> Trigger:
        """Returns a trigger that fires when the design has accepted everything queued."""
        return self._raw.drained()

    @property
    def sent(self) -> int:
        """Number of beats that the design has accepted."""
        return self._raw.sent()

    @property
    def pending(self) -> int:
        """Number of beats that the design has not accepted yet."""
        return self._raw.pending()


class _Listener:
    """The receiver of a stream: a sink or a monitor."""

    _bus = ""
    _drives = False

    def __init__(
        self,
        dut: Any,
        prefix: str,
        clock: Handle,
        *,
        reset: Handle | None = None,
        reset_active: bool = True,
        ready_latency: int = 0,
        symbol_bits: int | None = None,
        strict: bool = True,
    ) -> None:
        path = below(dut, prefix)
        self._raw = _core.RawListener(
            self._drives, path, clock, self._bus, ready_latency, symbol_bits, reset, reset_active, strict
        )

    async def recv(self) -> Frame:
        """Waits for the next packet."""
        while (parts := self._raw.try_recv()) is None:
            await self._raw.arrived()
        return Frame(*parts)

    async def recv_symbols(self, count: int) -> NDArray[np.uint64]:
        """Waits for the next symbols of a stream without packets.

        Returns
        -------
        ndarray of uint64, shape (count,)
        """
        symbols = self._raw.recv_symbols(count)
        await symbols.ended()
        return symbols.value()

    def try_recv(self) -> Frame | None:
        """Returns the next received packet, or None."""
        parts = self._raw.try_recv()
        return None if parts is None else Frame(*parts)

    def clear(self) -> None:
        """Discards what was received and not fetched. A reset discards only the packet in progress."""
        self._raw.clear()

    def __len__(self) -> int:
        return len(self._raw)

    @property
    def beats(self) -> int:
        """Number of beats received."""
        return self._raw.beats()

    @property
    def violations(self) -> list[str]:
        """Broken rules with their simulation times; only with ``strict=False``, otherwise they end the test."""
        return self._raw.violations()


class _Sink(_Listener):
    """The receiver of a stream, which drives ``ready``."""

    _drives = True

    def pause(self, pause: Pause, seed: int = 0) -> None:
        """Sets the cycles in which the sink is not ready.

        Parameters
        ----------
        pause : float or iterable of bool, optional
            A probability from 0 to less than 1, or a pattern (true: pause) that is repeated; None: never.
        seed : int
            Seed of the random numbers.

        Raises
        ------
        ValueError
            If the probability is out of range, or the pattern lets nothing through.
        """
        self._raw.set_pause(pause, seed)


class AvalonSource(_Source):
    """The driver of an Avalon-ST sink of the design.

    Parameters
    ----------
    dut : Hierarchy
        The design, or an instance in it whose signals are accessible.
    prefix : str
        Prefix of the names of the signals, such as ``"in_"``.
    clock : Handle
        The clock; beats move at its rising edges.
    reset : Handle, optional
        While the reset is active, the bus model is idle and checks nothing; the packet in progress is dropped.
    reset_active : bool
        The level at which the reset is active.
    ready_latency : int
        Cycles from ``ready`` to the beat it allows, from 0 to 64; Avalon-ST only.
    symbol_bits : int, optional
        Bits of a symbol. Default: 8 if the width of ``data`` is a multiple of 8, otherwise the whole of ``data``.

    Raises
    ------
    NoSuchSignal
        If ``valid`` or ``data`` is missing.
    HoverlockError
        If the symbols do not fill ``data``, or a signal has the wrong direction.

    >>> source = AvalonSource(dut, "in_", dut.clk, reset=dut.rst)
    >>> source.send(b"hello", channel=2)
    >>> await source.drained()
    """

    _bus = "avalon"


class AvalonSink(_Sink):
    """A receiver of packets from an Avalon-ST source of the design, which checks the rules of the bus.

    Parameters
    ----------
    dut : Hierarchy
        The design, or an instance in it whose signals are accessible.
    prefix : str
        Prefix of the names of the signals, such as ``"in_"``.
    clock : Handle
        The clock; beats move at its rising edges.
    reset : Handle, optional
        While the reset is active, the bus model is idle and checks nothing; the packet in progress is dropped.
    reset_active : bool
        The level at which the reset is active.
    ready_latency : int
        Cycles from ``ready`` to the beat it allows, from 0 to 64; Avalon-ST only.
    symbol_bits : int, optional
        Bits of a symbol. Default: 8 if the width of ``data`` is a multiple of 8, otherwise the whole of ``data``.
    strict : bool
        Whether a broken rule ends the test with ``ProtocolError``; otherwise it is added to ``violations``.

    Raises
    ------
    NoSuchSignal
        If ``valid`` or ``data`` is missing.
    HoverlockError
        If the symbols do not fill ``data``, or a signal has the wrong direction.

    >>> sink = AvalonSink(dut, "out_", dut.clk, reset=dut.rst, symbol_bits=16)
    >>> frame = await sink.recv()
    >>> frame.symbols, frame.channel
    """

    _bus = "avalon"


class AvalonMonitor(_Listener):
    """A passive listener to an Avalon-ST stream, which checks the rules of the bus. Parameters as of `AvalonSink`.

    >>> monitor = AvalonMonitor(dut, "out_", dut.clk, reset=dut.rst, strict=False)
    >>> assert monitor.violations == []
    """

    _bus = "avalon"


class AxiSource(_Source):
    """The driver of an AXI4-Stream slave of the design. Parameters as of `AvalonSource`.

    >>> source = AxiSource(dut, "s_axis_", dut.clk, reset=dut.rst_n, reset_active=False)
    >>> source.send(Frame(np.arange(10, dtype=np.uint8), error=1))
    """

    _bus = "axi"


class AxiSink(_Sink):
    """A receiver of packets from an AXI4-Stream master of the design, which checks the rules of the bus. Parameters as of
    `AvalonSink`.

    >>> sink = AxiSink(dut, "m_axis_", dut.clk, reset=dut.rst_n, reset_active=False)
    >>> bytes(await sink.recv())
    """

    _bus = "axi"


class AxiMonitor(_Listener):
    """A passive listener to an AXI4-Stream, which checks the rules of the bus. Parameters as of `AvalonSink`.

    >>> monitor = AxiMonitor(dut, "m_axis_", dut.clk, reset=dut.rst_n, reset_active=False)
    >>> frame = await monitor.recv()
    """

    _bus = "axi"
