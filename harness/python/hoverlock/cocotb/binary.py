"""``cocotb.binary`` of cocotb 1: mutable binary values.

>>> value = BinaryValue(n_bits=8, bigEndian=False)
>>> value.integer = 200
>>> value.binstr, value.signed_integer
('11001000', -56)
"""

from __future__ import annotations

import operator
import warnings
from typing import Any

from ..errors import RangeError
from .types import LogicArray, Range

__all__ = ["BinaryRepresentation", "BinaryValue"]


class BinaryRepresentation:
    """The encoding of negative numbers; both signed ones are two's complement here."""

    UNSIGNED = 0
    SIGNED_MAGNITUDE = 1
    TWOS_COMPLEMENT = 2


class BinaryValue(LogicArray):
    """A binary value as a number, a string or bytes.

    ``bigEndian``: index 0 is the leftmost digit, missing digits are appended on the right, bytes have the order of the digits,
    and the digits of a number in two's complement are reversed. Otherwise index 0 is the rightmost digit, missing digits are put
    on the left, and the first byte has the lowest digits. Without ``n_bits`` a value has as many digits as it needs.
    """

    def __init__(
        self,
        value: Any = None,
        n_bits: int | None = None,
        bigEndian: bool = True,  # noqa: N803
        binaryRepresentation: int = BinaryRepresentation.UNSIGNED,  # noqa: N803
        bits: int | None = None,
    ) -> None:
        super().__init__()
        self._n_bits = n_bits if n_bits is not None else bits
        self.big_endian = bigEndian
        self.binaryRepresentation = binaryRepresentation
        if value is not None:
            self.assign(value)

    @property
    def n_bits(self) -> int:
        """The number of digits."""
        return len(self) if self._n_bits is None else self._n_bits

    def assign(self, value: Any) -> None:
        """Sets the value from a number, a string of digits or bytes.

        Raises
        ------
        RangeError
            If a number does not fit. Of a string or bytes, digits on the left are removed, with a ``RuntimeWarning``.
        """
        if isinstance(value, (bytes, bytearray)):
            ordered = value if self.big_endian else value[::-1]
            self._digits = self._fitted("".join(format(byte, "08b") for byte in ordered))
        elif isinstance(value, (str, LogicArray)):
            self._digits = self._fitted(LogicArray(value)._digits)
        else:
            self._digits = self._digits_of(operator.index(value))
        last = len(self._digits) - 1
        self.range = Range(0, "to", last) if self.big_endian else Range(last, "downto", 0)

    def _digits_of(self, number: int) -> str:
        signed = self.binaryRepresentation != BinaryRepresentation.UNSIGNED
        size = (number if number >= 0 else ~number).bit_length() + signed
        if (number < 0 and not signed) or (self._n_bits is not None and size > self._n_bits):
            raise RangeError(f"{number} does not fit {'' if self._n_bits is None else f'{self._n_bits} '}digits")
        if number == 0:
            return self._fitted("")
        digits = format(number & ((1 << size) - 1), f"0{size}b")
        if not signed:
            return self._fitted(digits)
        if not self.big_endian:
            return self._fitted(digits, digits[0])
        return self._fitted(digits, digits[-1])[::-1]

    def _fitted(self, digits: str, fill: str = "0") -> str:
        """Returns as many digits as the value has: with ``fill`` for those that are missing, or without the leftmost."""
        missing = 0 if self._n_bits is None else self._n_bits - len(digits)
        if missing < 0:
            rest = digits[-missing:]
            warnings.warn(f"'{digits}' has more than {self._n_bits} digits: '{rest}' is left", RuntimeWarning, stacklevel=4)
            return rest
        return digits + fill * missing if self.big_endian else fill * missing + digits

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

    integer = property(get_value, assign, doc="The number, signed or unsigned as ``binaryRepresentation`` says.")
    signed_integer = property(lambda self: self.to_signed(), assign, doc="The number in two's complement.")
    binstr = property(lambda self: self._digits, assign, doc="The digits, leftmost first.")

    @property
    def buff(self) -> bytes:
        """The bytes, those of the leftmost digits first if ``bigEndian``, otherwise last."""
        return self.to_bytes(byteorder="big" if self.big_endian else "little")

    @buff.setter
    def buff(self, value: bytes) -> None:
        self.assign(value)

    def __int__(self) -> int:
        return self.value

    def __getitem__(self, index: int | slice) -> Any:
        part = super().__getitem__(index if isinstance(index, slice) else range(len(self))[index])
        return BinaryValue(str(part), bigEndian=self.big_endian, binaryRepresentation=self.binaryRepresentation)
