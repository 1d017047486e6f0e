"""Avalon-MM, AXI4-Lite and AXI4: masters, memories and the checker of AXI4."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._core import Handle
from ..errors import SimulationError
from ._path import below

if TYPE_CHECKING:
    from ..transfer import Pause

__all__ = ["AvalonMaster", "AvalonMemory", "AxiChecker", "AxiLiteMaster", "AxiLiteMemory", "AxiMaster", "AxiMemory"]


def _refuse(name: str, what: str, address: int, response: int) -> None:
    """Raises `SimulationError` if a slave responded with an error."""
    if response:
        names = {1: "SLVERR", 2: "DECERR", 3: "EXOKAY, which was not requested"}
        raise SimulationError(f"{name}: {what} at {address:#x} answered {names.get(response, response)}")


class _Master:
    """The master of single accesses."""

    _bus = ""

    def __init__(self, dut: Any, prefix: str, clock: Handle, *, read_latency: int = 0) -> None:
        self._raw = _core.RawMaster(below(dut, prefix), clock, self._bus, read_latency)
        self._name = prefix

    async def write(self, address: int, data: int, *, bytes: int | None = None) -> None:
        """Writes a word.

        Parameters
        ----------
        address : int
            The value of ``address`` (``awaddr``), in the unit of the slave.
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
    """A master for an Avalon-MM slave of the design: one access at a time, in the order of the calls.

    Parameters
    ----------
    dut : Hierarchy
        The design, or an instance in it whose signals are accessible.
    prefix : str
        Prefix of the names of the signals, such as ``"csr_"``.
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
            The cycles in which the master pauses between two words, as in `AvalonSource.pause`.

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
    """A master for an AXI4-Lite slave of the design: one read and one write at a time. Parameters as of `AvalonMaster`,
    without ``read_latency``.

    >>> csr = AxiLiteMaster(dut, "s_axi_", dut.clk)
    >>> await csr.write(0x10, 0xFF, bytes=0b0001)
    """

    _bus = "axi"

    def pause(self, pause: Pause, seed: int = 0) -> None:
        """Sets the cycles in which the master waits before it uses a channel, as in `AvalonSource.pause`."""
        self._raw.set_pause(pause, seed)


class AxiMaster:
    """A master for an AXI4 slave of the design: bursts of increasing addresses, one write and one read at a time. It checks
    the responses.

    Parameters
    ----------
    dut : Hierarchy
        The design, or an instance in it whose signals are accessible.
    prefix : str
        Prefix of the names of the signals, such as ``"s_axi_"``.
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
        self._raw = _core.RawMaster(below(dut, prefix), clock, "axi4", 0)
        self._name = prefix

    def pause(self, pause: Pause, seed: int = 0) -> None:
        """Sets the cycles in which the master pauses between beats, as in `AvalonSource.pause`."""
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
    """A memory of one of the buses."""

    _bus = ""

    def __init__(
        self, dut: Any, prefix: str, clock: Handle, *, reset: Handle | None = None, reset_active: bool = True
    ) -> None:
        self._raw = _core.RawMemory(below(dut, prefix), clock, self._bus, reset, reset_active)
        self._step = self._addresses_of_a_word(dut, prefix)

    def _addresses_of_a_word(self, dut: Any, prefix: str) -> int:
        return 1

    def stall(self, pause: Pause, seed: int = 0) -> None:
        """Sets the cycles in which the memory makes the master wait, as in `AvalonSource.pause`."""
        self._raw.set_stall(pause, seed)

    def __getitem__(self, address: int) -> int:
        return self._raw[address]

    def __setitem__(self, address: int, word: int) -> None:
        self._raw[address] = word

    def read(self, address: int, count: int) -> NDArray[np.uint64]:
        """Returns words that start at an address.

        Returns
        -------
        ndarray of uint64, shape (count,)

        >>> assert (memory.read(0x400, 64) == memory.read(0, 64) + 1).all()
        """
        return self._raw.read(address, count, self._step)

    def write(self, address: int, words: Iterable[int]) -> None:
        """Sets words that start at an address, such as an array or a program.

        >>> memory.write(0, np.arange(64))
        """
        self._raw.write(address, [int(word) for word in words], self._step)

    @property
    def accesses(self) -> int:
        """Number of words that the design has read and written."""
        return self._raw.accesses()


class AvalonMemory(_Memory):
    """A memory for an Avalon-MM master of the design. It checks the rules of the bus.

    Parameters
    ----------
    dut : Hierarchy
        The design, or an instance in it whose signals are accessible.
    prefix : str
        Prefix of the names of the signals, such as ``"csr_"``.
    clock : Handle
        The clock of the bus.
    reset : Handle, optional
        While the reset is active, the memory is idle and checks nothing.
    reset_active : bool
        The level at which the reset is active.
    step : int
        Distance between the addresses of two words: 1, or the bytes of a word if addresses count bytes.

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
        """Sets the read latency in cycles, from ``least`` (1 or more) to ``most``, drawn at random for each read.

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
    """A passive listener to an AXI4 bus, which checks the rules of master and slave. Parameters as of `AvalonMemory`,
    without ``step``.

    >>> checker = AxiChecker(dut, "m_axi_", dut.clk, reset=dut.rst)
    >>> checker.writes, checker.reads
    """

    def __init__(
        self, dut: Any, prefix: str, clock: Handle, *, reset: Handle | None = None, reset_active: bool = True
    ) -> None:
        self._raw = _core.RawChecker(below(dut, prefix), clock, reset, reset_active)

    @property
    def writes(self) -> int:
        """Number of bursts written."""
        return self._raw.bursts()[0]

    @property
    def reads(self) -> int:
        """Number of bursts read."""
        return self._raw.bursts()[1]
