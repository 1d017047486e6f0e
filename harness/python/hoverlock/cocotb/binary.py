"""``cocotb.binary`` of cocotb 1: mutable binary values.

>>> value = BinaryValue(n_bits=8, bigEndian=False)
>>> value.integer = 200
>>> value.binstr, value.signed_integer
('11001000', -56)
"""

from __future__ import annotations

from typing import Any

from .types import LogicArray

__all__ = ["BinaryRepresentation", "BinaryValue"]


class BinaryRepresentation:
    """The encoding of negative numbers."""

    UNSIGNED = 0
    SIGNED_MAGNITUDE = 1
    TWOS_COMPLEMENT = 2


class BinaryValue(LogicArray):
    """A binary value as a number, a string or bytes. ``bigEndian``: index 0 is the highest digit, otherwise the lowest."""

    def __init__(
        self,
        value: Any = None,
        n_bits: int | None = None,
        bigEndian: bool = True,  # noqa: N803
        binaryRepresentation: int = BinaryRepresentation.UNSIGNED,  # noqa: N803
        bits: int | None = None,
    ) -> None:
        n_bits = n_bits if n_bits is not None else bits
        self.big_endian = bigEndian
        self.binaryRepresentation = binaryRepresentation
        if value is None:
            value = "X" * (n_bits or 1)
        if isinstance(value, (bytes, bytearray)):
            value = int.from_bytes(value, "big") if not n_bits else format(int.from_bytes(value, "big"), f"0{n_bits}b")
        if isinstance(value, str) and n_bits and len(value) < n_bits:
            value = value.rjust(n_bits, "0")
        super().__init__(value, n_bits)

    @property
    def n_bits(self) -> int:
        """The number of digits."""
        return len(self)

    def assign(self, value: Any) -> None:
        """Sets the value from a number, a string of digits or bytes."""
        if isinstance(value, (bytes, bytearray)):
            value = int.from_bytes(value, "big")
        self._digits = LogicArray(value, None if isinstance(value, str) else len(self))._digits.rjust(len(self), "0")

    set_value = assign

    def get_value(self) -> int:
        """The number, signed or unsigned as ``binaryRepresentation`` says."""
        return self.value

    @property
    def value(self) -> int:
        """The number, signed or unsigned as ``binaryRepresentation`` says."""
        unsigned = self.binaryRepresentation == BinaryRepresentation.UNSIGNED
        return self.to_unsigned() if unsigned else self.to_signed()

    @value.setter
    def value(self, value: Any) -> None:
        self.assign(value)

    integer = property(lambda self: self.to_unsigned(), assign, doc="The unsigned number.")
    signed_integer = property(lambda self: self.to_signed(), assign, doc="The number in two's complement.")
    binstr = property(lambda self: self._digits, assign, doc="The digits, highest first.")
    buff = property(lambda self: self.to_bytes(), assign, doc="The bytes, highest first.")

    def __int__(self) -> int:
        return self.value

    def __getitem__(self, index: int | slice) -> Any:
        digits = self._digits if self.big_endian else self._digits[::-1]
        if isinstance(index, slice):
            first, last = sorted((index.start or 0, len(self) - 1 if index.stop is None else index.stop))
            part = digits[first : last + 1]
            return BinaryValue(part if self.big_endian else part[::-1], bigEndian=self.big_endian)
        return BinaryValue(digits[index])
