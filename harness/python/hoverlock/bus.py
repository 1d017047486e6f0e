"""Bus models of the engine: they work at the edges of a clock without a task of Python, and check the protocol.

>>> source = AvalonSource(dut, "in_", dut.clk, reset=dut.rst)
>>> sink = AvalonSink(dut, "out_", dut.clk, reset=dut.rst)
>>> sink.pause(0.25, seed=3)
>>> source.send(np.arange(100, dtype=np.uint8))
>>> frame = await sink.recv()
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._core import Handle
from .errors import SimulationError
from .triggers import Trigger

__all__ = [
    "AvalonMaster",
    "AvalonMemory",
    "AvalonMonitor",
    "AvalonSink",
    "AvalonSource",
    "AxiLiteMaster",
    "AxiLiteMemory",
    "AxiMonitor",
    "AxiSink",
    "AxiSource",
    "Frame",
]


@dataclass
class Frame:
    """A packet: its symbols as an array, and what its last beat says.

    >>> source.send(Frame(np.arange(10, dtype=np.uint8), channel=2))
    """

    symbols: Any
    channel: int = 0
    """``channel``, or ``tid``."""
    error: int = 0
    """``error``, or ``tuser``."""
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
        """Queues a packet: a ``Frame``, bytes, or symbols of any kind, arrays too."""
        if isinstance(frame, Frame):
            self._raw.send(frame.symbols, frame.channel, frame.error, frame.destination)
        else:
            self._raw.send(list(frame), channel, error, 0)

    def pause(self, pause: float | Iterable[bool] | None, seed: int = 0) -> None:
        """In which cycles it holds back: with a probability, or as a pattern says again and again."""
        self._raw.set_pause(pause, seed)

    def drained(self) -> Trigger:
        """Until everything queued was taken."""
        return self._raw.drained()

    @property
    def sent(self) -> int:
        """Beats the design has taken."""
        return self._raw.sent()

    @property
    def pending(self) -> int:
        """Beats still to be taken."""
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
        """The next packet, waiting for it."""
        while (parts := self._raw.try_recv()) is None:
            await self._raw.arrived()
        return Frame(*parts)

    async def recv_symbols(self, count: int) -> Any:
        """The next symbols of a stream without packets, waiting for them, as an array."""
        symbols = self._raw.recv_symbols(count)
        await symbols.ended()
        return symbols.value()

    def try_recv(self) -> Frame | None:
        """The next packet, if there is one."""
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
        """Rules that were broken, with their times, where ``strict=False`` keeps them from ending the run."""
        return self._raw.violations()


class _Sink(_Listener):
    """Takes a stream from the design."""

    _drives = True

    def pause(self, pause: float | Iterable[bool] | None, seed: int = 0) -> None:
        """In which cycles it is not ready: with a probability, or as a pattern says again and again."""
        self._raw.set_pause(pause, seed)


class AvalonSource(_Source):
    """Drives an Avalon-ST sink of the design.

    >>> source = AvalonSource(dut, "in_", dut.clk, reset=dut.rst)
    >>> source.send(b"hello", channel=2)
    >>> await source.drained()
    """

    _bus = "avalon"


class AvalonSink(_Sink):
    """Takes from an Avalon-ST source of the design.

    >>> sink = AvalonSink(dut, "out_", dut.clk, reset=dut.rst, symbol_bits=16)
    >>> frame = await sink.recv()
    >>> frame.symbols, frame.channel
    """

    _bus = "avalon"


class AvalonMonitor(_Listener):
    """Listens to an Avalon-ST stream and checks its rules.

    >>> monitor = AvalonMonitor(dut, "out_", dut.clk, reset=dut.rst, strict=False)
    >>> assert monitor.violations == []
    """

    _bus = "avalon"


class AxiSource(_Source):
    """Drives an AXI4-Stream slave of the design.

    >>> source = AxiSource(dut, "s_axis_", dut.clk, reset=dut.rst_n, reset_active=False)
    >>> source.send(Frame(np.arange(10, dtype=np.uint8), error=1))
    """

    _bus = "axi"


class AxiSink(_Sink):
    """Takes from an AXI4-Stream master of the design.

    >>> sink = AxiSink(dut, "m_axis_", dut.clk, reset=dut.rst_n, reset_active=False)
    >>> bytes(await sink.recv())
    """

    _bus = "axi"


class AxiMonitor(_Listener):
    """Listens to an AXI4-Stream and checks its rules.

    >>> monitor = AxiMonitor(dut, "m_axis_", dut.clk, reset=dut.rst_n, reset_active=False)
    >>> frame = await monitor.recv()
    """

    _bus = "axi"


class _Master:
    _bus = ""

    def __init__(self, dut: Any, prefix: str, clock: Handle, *, read_latency: int = 0) -> None:
        self._raw = _core.RawMaster(_below(dut, prefix), clock, self._bus, read_latency)
        self._name = prefix

    async def write(self, address: int, data: int, *, bytes: int | None = None) -> None:
        """Writes a word, or the bytes of it that a mask names."""
        access = self._raw.write(address, data, bytes)
        await access.ended()
        self._check("write", address, access.value()[1])

    async def read(self, address: int) -> int:
        """Reads a word."""
        access = self._raw.read(address)
        await access.ended()
        word, response = access.value()
        self._check("read", address, response)
        return word

    def _check(self, what: str, address: int, response: int) -> None:
        if response:
            names = {1: "SLVERR", 2: "DECERR", 3: "a code that AXI4-Lite does not have"}
            raise SimulationError(f"{self._name}: {what} at {address:#x} answered {names.get(response, response)}")


class AvalonMaster(_Master):
    """Reads and writes an Avalon-MM slave of the design.

    >>> csr = AvalonMaster(dut, "csr_", dut.clk, read_latency=1)
    >>> await csr.write(0x10, 1)
    """

    _bus = "avalon"

    async def write_burst(
        self, address: int, words: Iterable[int], *, pause: float | Iterable[bool] | None = None, seed: int = 0
    ) -> None:
        """Writes words, an array too, in one burst of ``burstcount``; ``pause`` says in which cycles it holds back
        between two of them.

        >>> await mem.write_burst(0x100, np.arange(8), pause=0.3, seed=1)
        """
        await self._raw.write_burst(address, [int(word) for word in words], pause, seed).ended()

    async def read_burst(self, address: int, count: int) -> NDArray[np.uint64]:
        """Reads so many words in one burst, as an array; the slave needs ``readdatavalid``.

        >>> assert (await mem.read_burst(0x100, 8) == np.arange(8)).all()
        """
        burst = self._raw.read_burst(address, count)
        await burst.ended()
        return burst.words()


class AxiLiteMaster(_Master):
    """Reads and writes an AXI4-Lite slave of the design; an error response raises ``SimulationError``.

    >>> csr = AxiLiteMaster(dut, "s_axi_", dut.clk)
    >>> await csr.write(0x10, 0xFF, bytes=0b0001)
    """

    _bus = "axi"

    def pause(self, pause: float | Iterable[bool] | None, seed: int = 0) -> None:
        """In which cycles it holds back before each of its channels."""
        self._raw.set_pause(pause, seed)


class _Memory:
    _bus = ""

    def __init__(
        self, dut: Any, prefix: str, clock: Handle, *, reset: Handle | None = None, reset_active: bool = True
    ) -> None:
        self._raw = _core.RawMemory(_below(dut, prefix), clock, self._bus, reset, reset_active)
        self._step = self._addresses_of_a_word(dut, prefix)

    def _addresses_of_a_word(self, dut: Any, prefix: str) -> int:
        return 1

    def stall(self, pause: float | Iterable[bool] | None, seed: int = 0) -> None:
        """In which cycles it keeps the design waiting."""
        self._raw.set_stall(pause, seed)

    def __getitem__(self, address: int) -> int:
        return self._raw[address]

    def __setitem__(self, address: int, word: int) -> None:
        self._raw[address] = word

    def read(self, address: int, count: int) -> NDArray[np.uint64]:
        """So many words from an address on, as an array.

        >>> assert (memory.read(0x400, 64) == memory.read(0, 64) + 1).all()
        """
        return self._raw.read(address, count, self._step)

    def write(self, address: int, words: Iterable[int]) -> None:
        """Puts words into it from an address on: an array, a program.

        >>> memory.write(0, np.arange(64))
        """
        self._raw.write(address, [int(word) for word in words], self._step)

    @property
    def accesses(self) -> int:
        """How often the design came."""
        return self._raw.accesses()


class AvalonMemory(_Memory):
    """A memory for an Avalon-MM master of the design; addresses count as the master counts.

    >>> memory = AvalonMemory(dut, "m_", dut.clk, reset=dut.rst)
    >>> memory.stall(0.3, seed=1)
    >>> memory.latency(1, 5, seed=2)

    Where addresses count bytes, ``step`` is the bytes of a word: the words of a burst, and of ``read`` and ``write``, are
    as far apart.

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
        """How many cycles the answer to a read takes, drawn anew for each."""
        self._raw.set_latency(least, most, seed)


class AxiLiteMemory(_Memory):
    """A memory for an AXI4-Lite master of the design; addresses count bytes.

    >>> memory = AxiLiteMemory(dut, "m_axi_", dut.clk, reset=dut.rst_n, reset_active=False)
    >>> memory.write(0, [1, 2, 3])
    >>> memory[8]
    3
    """

    _bus = "axi"

    def _addresses_of_a_word(self, dut: Any, prefix: str) -> int:
        return len(getattr(dut, f"{prefix}rdata")) // 8


def _below(dut: Any, prefix: str) -> str:
    path = getattr(dut, "_path", "")
    return f"{path}.{prefix}" if path else prefix
