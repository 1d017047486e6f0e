"""Bus models written in Rust: they run at the edges of a clock, without a Python task, and check the protocol.

>>> source = AvalonSource(dut, "in_", dut.clk, reset=dut.rst)
>>> sink = AvalonSink(dut, "out_", dut.clk, reset=dut.rst)
>>> sink.pause(0.25, seed=3)
>>> source.send(np.arange(100, dtype=np.uint8))
>>> frame = await sink.recv()
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._core import Handle
from .errors import SimulationError
from .triggers import Trigger

if TYPE_CHECKING:
    from .transfer import Pause

__all__ = [
    "AvalonMaster",
    "AvalonMemory",
    "AvalonMonitor",
    "AvalonSink",
    "AvalonSource",
    "AxiChecker",
    "AxiLiteMaster",
    "AxiLiteMemory",
    "AxiMaster",
    "AxiMemory",
    "AxiMonitor",
    "AxiSink",
    "AxiSource",
    "Frame",
]


@dataclass
class Frame:
    """A packet: its symbols, channel and error.

    >>> source.send(Frame(np.arange(10, dtype=np.uint8), channel=2))
    """

    symbols: Any
    """Symbols in the order of the stream: ``uint64`` array of shape (symbols,) if received; any integers to be sent."""
    channel: int = 0
    """``channel``, or ``tid``."""
    error: int = 0
    """``error``, or ``tuser``, of the last beat."""
    destination: int = 0
    """``tdest``."""

    def __bytes__(self) -> bytes:
        return bytes(int(s) for s in self.symbols)

    def __len__(self) -> int:
        return len(self.symbols)


class _Source:
    """Drives a stream into the design."""

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
            _below(dut, prefix), clock, self._bus, ready_latency, symbol_bits, reset, reset_active
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
            If the packet is empty, a symbol, channel or error does not fit, or the last beat is not full where neither
            ``empty`` nor ``tkeep`` can say so.
        """
        if isinstance(frame, Frame):
            self._raw.send(frame.symbols, frame.channel, frame.error, frame.destination)
        else:
            self._raw.send(list(frame), channel, error, 0)

    def pause(self, pause: Pause, seed: int = 0) -> None:
        """Sets in which cycles it offers no new beat.

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

    def drained(self) -> Trigger:
        """A trigger: the design has taken everything queued."""
        return self._raw.drained()

    @property
    def sent(self) -> int:
        """Beats the design has taken."""
        return self._raw.sent()

    @property
    def pending(self) -> int:
        """Beats the design has not taken yet."""
        return self._raw.pending()


class _Listener:
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
        path = _below(dut, prefix)
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
        """The next packet that was received, or None."""
        parts = self._raw.try_recv()
        return None if parts is None else Frame(*parts)

    def __len__(self) -> int:
        return len(self._raw)

    @property
    def beats(self) -> int:
        """Beats seen."""
        return self._raw.beats()

    @property
    def violations(self) -> list[str]:
        """Broken rules, with their simulation times, where ``strict=False`` does not end the test."""
        return self._raw.violations()


class _Sink(_Listener):
    """Takes a stream from the design."""

    _drives = True

    def pause(self, pause: Pause, seed: int = 0) -> None:
        """Sets in which cycles it is not ready.

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
    """Drives an Avalon-ST sink of the design.

    Parameters
    ----------
    dut : Hierarchy
        The design, or an instance in it whose signals are accessible.
    prefix : str
        What the names of the signals begin with, such as ``"in_"``.
    clock : Handle
        The clock at whose rising edges beats move.
    reset : Handle, optional
        While it is active, the bus model is idle and checks nothing.
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
        If the symbols do not fill ``data``, or the signals go the wrong way.

    >>> source = AvalonSource(dut, "in_", dut.clk, reset=dut.rst)
    >>> source.send(b"hello", channel=2)
    >>> await source.drained()
    """

    _bus = "avalon"


class AvalonSink(_Sink):
    """Takes packets from an Avalon-ST source of the design, and checks the rules of the bus.

    Parameters
    ----------
    dut : Hierarchy
        The design, or an instance in it whose signals are accessible.
    prefix : str
        What the names of the signals begin with, such as ``"in_"``.
    clock : Handle
        The clock at whose rising edges beats move.
    reset : Handle, optional
        While it is active, the bus model is idle and checks nothing.
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
        If the symbols do not fill ``data``, or the signals go the wrong way.

    >>> sink = AvalonSink(dut, "out_", dut.clk, reset=dut.rst, symbol_bits=16)
    >>> frame = await sink.recv()
    >>> frame.symbols, frame.channel
    """

    _bus = "avalon"


class AvalonMonitor(_Listener):
    """Listens to an Avalon-ST stream without driving it, and checks the rules of the bus. Parameters as of `AvalonSink`.

    >>> monitor = AvalonMonitor(dut, "out_", dut.clk, reset=dut.rst, strict=False)
    >>> assert monitor.violations == []
    """

    _bus = "avalon"


class AxiSource(_Source):
    """Drives an AXI4-Stream slave of the design. Parameters as of `AvalonSource`.

    >>> source = AxiSource(dut, "s_axis_", dut.clk, reset=dut.rst_n, reset_active=False)
    >>> source.send(Frame(np.arange(10, dtype=np.uint8), error=1))
    """

    _bus = "axi"


class AxiSink(_Sink):
    """Takes packets from an AXI4-Stream master of the design, and checks the rules of the bus. Parameters as of `AvalonSink`.

    >>> sink = AxiSink(dut, "m_axis_", dut.clk, reset=dut.rst_n, reset_active=False)
    >>> bytes(await sink.recv())
    """

    _bus = "axi"


class AxiMonitor(_Listener):
    """Listens to an AXI4-Stream without driving it, and checks the rules of the bus. Parameters as of `AvalonSink`.

    >>> monitor = AxiMonitor(dut, "m_axis_", dut.clk, reset=dut.rst_n, reset_active=False)
    >>> frame = await monitor.recv()
    """

    _bus = "axi"


def _refuse(name: str, what: str, address: int, response: int) -> None:
    """Raises if a slave responded with an error."""
    if response:
        names = {1: "SLVERR", 2: "DECERR", 3: "EXOKAY, which nobody asked for"}
        raise SimulationError(f"{name}: {what} at {address:#x} answered {names.get(response, response)}")


class _Master:
    _bus = ""

    def __init__(self, dut: Any, prefix: str, clock: Handle, *, read_latency: int = 0) -> None:
        self._raw = _core.RawMaster(_below(dut, prefix), clock, self._bus, read_latency)
        self._name = prefix

    async def write(self, address: int, data: int, *, bytes: int | None = None) -> None:
        """Writes a word.

        Parameters
        ----------
        address : int
            As the slave's ``address`` (``awaddr``) counts.
        data : int
            The word.
        bytes : int, optional
            Mask of the bytes to write, bit 0 the lowest. Default: all.

        Raises
        ------
        RangeError
            If a value does not fit its signal.
        SimulationError
            If an AXI4-Lite slave responds with an error.
        """
        access = self._raw.write(address, data, bytes)
        await access.ended()
        self._check("write", address, access.value()[1])

    async def read(self, address: int) -> int:
        """Reads a word from an address.

        Raises
        ------
        RangeError
            If the address does not fit its signal.
        SimulationError
            If an AXI4-Lite slave responds with an error.
        """
        access = self._raw.read(address)
        await access.ended()
        word, response = access.value()
        self._check("read", address, response)
        return word

    def _check(self, what: str, address: int, response: int) -> None:
        _refuse(self._name, what, address, response)


class AvalonMaster(_Master):
    """Reads and writes an Avalon-MM slave of the design: one access at a time, in the order of the calls.

    Parameters
    ----------
    dut : Hierarchy
        The design, or an instance in it whose signals are accessible.
    prefix : str
        What the names of the signals begin with, such as ``"csr_"``.
    clock : Handle
        The clock of the bus.
    read_latency : int
        Cycles from a read to its data, for slaves without ``readdatavalid``.

    Raises
    ------
    NoSuchSignal
        If there is no ``address``.

    >>> csr = AvalonMaster(dut, "csr_", dut.clk, read_latency=1)
    >>> await csr.write(0x10, 1)
    """

    _bus = "avalon"

    async def write_burst(
        self, address: int, words: Iterable[int], *, pause: Pause = None, seed: int = 0
    ) -> None:
        """Writes words in one burst.

        Parameters
        ----------
        address : int
            Address of the first word.
        words : iterable of int
            The words, such as an array.
        pause, seed
            In which cycles it pauses between two words, as in `AvalonSource.pause`.

        Raises
        ------
        HoverlockError
            If the slave has no ``burstcount``, or one too narrow for the length.

        >>> await mem.write_burst(0x100, np.arange(8), pause=0.3, seed=1)
        """
        await self._raw.write_burst(address, [int(word) for word in words], pause, seed).ended()

    async def read_burst(self, address: int, count: int) -> NDArray[np.uint64]:
        """Reads words in one burst.

        Returns
        -------
        ndarray of uint64, shape (count,)

        Raises
        ------
        HoverlockError
            If the slave has no ``readdatavalid``, no ``burstcount``, or one too narrow for the length.

        >>> assert (await mem.read_burst(0x100, 8) == np.arange(8)).all()
        """
        burst = self._raw.read_burst(address, count)
        await burst.ended()
        return burst.words()


class AxiLiteMaster(_Master):
    """Reads and writes an AXI4-Lite slave of the design: one read and one write at a time. Parameters as of `AvalonMaster`,
    without ``read_latency``.

    >>> csr = AxiLiteMaster(dut, "s_axi_", dut.clk)
    >>> await csr.write(0x10, 0xFF, bytes=0b0001)
    """

    _bus = "axi"

    def pause(self, pause: Pause, seed: int = 0) -> None:
        """Sets in which cycles it waits before it uses a channel, as in `AvalonSource.pause`."""
        self._raw.set_pause(pause, seed)


class AxiMaster:
    """Reads and writes an AXI4 slave of the design in bursts of increasing addresses, and checks its answers: one write and
    one read at a time.

    Parameters
    ----------
    dut : Hierarchy
        The design, or an instance in it whose signals are accessible.
    prefix : str
        What the names of the signals begin with, such as ``"s_axi_"``.
    clock : Handle
        The clock of the bus.

    Raises
    ------
    NoSuchSignal
        If there is no ``awaddr``, ``awlen``, ``wlast`` and the like. ``wstrb``, responses, sizes, kinds of burst and ids may
        be missing.

    >>> memory = AxiMaster(dut, "s_axi_", dut.clk)
    >>> await memory.write_burst(0x100, np.arange(8))
    >>> assert (await memory.read_burst(0x100, 8) == np.arange(8)).all()
    """

    def __init__(self, dut: Any, prefix: str, clock: Handle) -> None:
        self._raw = _core.RawMaster(_below(dut, prefix), clock, "axi4", 0)
        self._name = prefix

    def pause(self, pause: Pause, seed: int = 0) -> None:
        """Sets in which cycles it pauses between beats, as in `AvalonSource.pause`."""
        self._raw.set_pause(pause, seed)

    async def write(self, address: int, data: int) -> None:
        """Writes a word: a burst of one. Raises as `write_burst`."""
        await self.write_burst(address, [data])

    async def read(self, address: int) -> int:
        """Reads a word: a burst of one. Raises as `read_burst`."""
        return int((await self.read_burst(address, 1))[0])

    async def write_burst(self, address: int, words: Iterable[int]) -> None:
        """Writes words in one burst.

        Parameters
        ----------
        address : int
            Byte address of the first word, a multiple of the word's bytes.
        words : iterable of int
            1 to 256 words as wide as the data, such as an array; they must not cross a multiple of 4 KiB.

        Raises
        ------
        HoverlockError
            If the burst is not possible.
        ProtocolError
            If the slave breaks a rule of the bus.
        SimulationError
            If the slave responds with an error.
        """
        burst = self._raw.write_burst(address, [int(word) for word in words], None, 0)
        await burst.ended()
        _refuse(self._name, "write", address, burst.response())

    async def read_burst(self, address: int, count: int) -> NDArray[np.uint64]:
        """Reads words in one burst. Raises as `write_burst`.

        Returns
        -------
        ndarray of uint64, shape (count,)
        """
        burst = self._raw.read_burst(address, count)
        await burst.ended()
        _refuse(self._name, "read", address, burst.response())
        return burst.words()


class _Memory:
    _bus = ""

    def __init__(
        self, dut: Any, prefix: str, clock: Handle, *, reset: Handle | None = None, reset_active: bool = True
    ) -> None:
        self._raw = _core.RawMemory(_below(dut, prefix), clock, self._bus, reset, reset_active)
        self._step = self._addresses_of_a_word(dut, prefix)

    def _addresses_of_a_word(self, dut: Any, prefix: str) -> int:
        return 1

    def stall(self, pause: Pause, seed: int = 0) -> None:
        """Sets in which cycles it keeps the master waiting, as in `AvalonSource.pause`."""
        self._raw.set_stall(pause, seed)

    def __getitem__(self, address: int) -> int:
        return self._raw[address]

    def __setitem__(self, address: int, word: int) -> None:
        self._raw[address] = word

    def read(self, address: int, count: int) -> NDArray[np.uint64]:
        """Words from an address on.

        Returns
        -------
        ndarray of uint64, shape (count,)

        >>> assert (memory.read(0x400, 64) == memory.read(0, 64) + 1).all()
        """
        return self._raw.read(address, count, self._step)

    def write(self, address: int, words: Iterable[int]) -> None:
        """Sets words from an address on, such as an array or a program.

        >>> memory.write(0, np.arange(64))
        """
        self._raw.write(address, [int(word) for word in words], self._step)

    @property
    def accesses(self) -> int:
        """Words that the design has read and written."""
        return self._raw.accesses()


class AvalonMemory(_Memory):
    """A memory for an Avalon-MM master of the design. It checks the rules of the bus.

    Parameters
    ----------
    dut : Hierarchy
        The design, or an instance in it whose signals are accessible.
    prefix : str
        What the names of the signals begin with, such as ``"csr_"``.
    clock : Handle
        The clock of the bus.
    reset : Handle, optional
        While it is active, the memory is idle and checks nothing.
    reset_active : bool
        The level at which the reset is active.
    step : int
        Distance between the addresses of two words: 1, or the bytes of a word where addresses count bytes.

    Raises
    ------
    NoSuchSignal
        If there is no ``address``.

    >>> memory = AvalonMemory(dut, "m_", dut.clk, reset=dut.rst)
    >>> memory.stall(0.3, seed=1)
    >>> memory.latency(1, 5, seed=2)

    With addresses that count bytes:

    >>> memory = AvalonMemory(dut, "m_", dut.clk, reset=dut.rst, step=4)
    >>> memory.write(0x100, np.arange(8))
    >>> memory[0x104]
    1
    """

    _bus = "avalon"

    def __init__(
        self,
        dut: Any,
        prefix: str,
        clock: Handle,
        *,
        reset: Handle | None = None,
        reset_active: bool = True,
        step: int = 1,
    ) -> None:
        super().__init__(dut, prefix, clock, reset=reset, reset_active=reset_active)
        self._step = step
        self._raw.set_step(step)

    def latency(self, least: int, most: int, seed: int = 0) -> None:
        """Sets how many cycles the answer to a read takes, from ``least`` (1 or more) to ``most``, at random for each read.

        Raises
        ------
        ValueError
            If ``least`` is 0 or greater than ``most``.
        """
        self._raw.set_latency(least, most, seed)


class AxiLiteMemory(_Memory):
    """A memory for an AXI4-Lite master of the design; addresses count bytes. It checks the rules of the bus. Parameters as
    of `AvalonMemory`, without ``step``.

    >>> memory = AxiLiteMemory(dut, "m_axi_", dut.clk, reset=dut.rst_n, reset_active=False)
    >>> memory.write(0, [1, 2, 3])
    >>> memory[8]
    3
    """

    _bus = "axi"

    def _addresses_of_a_word(self, dut: Any, prefix: str) -> int:
        return len(getattr(dut, f"{prefix}rdata")) // 8


class AxiMemory(_Memory):
    """A memory for an AXI4 master of the design, with bursts of all kinds; addresses count bytes. It checks the rules of the
    bus. Parameters as of `AvalonMemory`, without ``step``.

    >>> memory = AxiMemory(dut, "m_axi_", dut.clk, reset=dut.rst)
    >>> memory.write(0, np.arange(64))
    """

    _bus = "axi4"

    def _addresses_of_a_word(self, dut: Any, prefix: str) -> int:
        return len(getattr(dut, f"{prefix}rdata")) // 8


class AxiChecker:
    """Listens to an AXI4 bus without driving it, and checks the rules of master and slave. Parameters as of `AvalonMemory`,
    without ``step``.

    >>> checker = AxiChecker(dut, "m_axi_", dut.clk, reset=dut.rst)
    >>> checker.writes, checker.reads
    """

    def __init__(
        self, dut: Any, prefix: str, clock: Handle, *, reset: Handle | None = None, reset_active: bool = True
    ) -> None:
        self._raw = _core.RawChecker(_below(dut, prefix), clock, reset, reset_active)

    @property
    def writes(self) -> int:
        """Bursts written."""
        return self._raw.bursts()[0]

    @property
    def reads(self) -> int:
        """Bursts read."""
        return self._raw.bursts()[1]


def _below(dut: Any, prefix: str) -> str:
    path = getattr(dut, "_below", "")
    return f"{path}.{prefix}" if path else prefix
