"""``cocotb.types`` and ``cocotb.binary``: values made by benches. Two states only, as Verilator has."""

from __future__ import annotations

__all__ = ["BinaryValue", "Logic", "LogicArray"]


class LogicArray(int):
    """A whole number that knows its width: ``LogicArray("1010")``, ``LogicArray(10, 4)``."""

    n_bits: int

    def __new__(cls, value: int | str | None = None, n_bits: int | None = None, bigEndian: bool = True) -> LogicArray:  # noqa: N803
        if isinstance(value, str):
            text = value.replace("_", "")
            if set(text) - {"0", "1"}:
                raise ValueError(f"'{value}': Verilator has two states, 0 and 1")
            number, width = int(text, 2) if text else 0, n_bits or len(text)
        else:
            number = int(value or 0)
            width = n_bits or max(number.bit_length(), 1)
        made = super().__new__(cls, number & ((1 << width) - 1))
        made.n_bits = width
        return made

    @property
    def integer(self) -> int:
        """The unsigned number."""
        return int(self)

    def to_unsigned(self) -> int:
        """The unsigned number."""
        return int(self)

    @property
    def signed_integer(self) -> int:
        """The number in two's complement."""
        number = int(self)
        return number - (1 << self.n_bits) if number >> (self.n_bits - 1) else number

    def to_signed(self) -> int:
        """The number in two's complement."""
        return self.signed_integer

    @property
    def binstr(self) -> str:
        """Its digits, highest first."""
        return format(int(self), f"0{self.n_bits}b")

    @property
    def is_resolvable(self) -> bool:
        """Always."""
        return True

    def __len__(self) -> int:
        return self.n_bits

    def __str__(self) -> str:
        return self.binstr


BinaryValue = LogicArray


class Logic(LogicArray):
    """One bit."""

    def __new__(cls, value: int | str | bool = 0) -> Logic:
        if value not in (0, 1, "0", "1"):
            raise ValueError(f"'{value}': Verilator has two states, 0 and 1")
        made = super().__new__(cls, int(value), 1)
        assert isinstance(made, Logic)
        return made
