"""``cocotb.types``: values for calculations in benches.

Like cocotb's, they have more than two states, so that a bench may compare with ``LogicArray("XXXX")``. A design has two: a
write of such a value to a signal is an error.

>>> LogicArray("1010").to_unsigned()
10
>>> LogicArray.from_signed(-2, 4)
LogicArray('1110', Range(3, 'downto', 0))
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from ..._core import ArrayHandle

__all__ = ["AbstractArray", "AbstractMutableArray", "Array", "Bit", "IndexingChangedWarning", "Logic", "LogicArray", "Range", "concat"]

_DIGITS = "UX01ZWLH-"


class IndexingChangedWarning(UserWarning):
    """cocotb 2's warning of indices that meant another bit in cocotb 1; not given here."""


class Range:
    """Indices from left to right: ``Range(7, "downto", 0)``.

    >>> list(Range(3, "downto", 0))
    [3, 2, 1, 0]
    """

    def __init__(self, left: int, direction: str | int | None = None, right: int | None = None) -> None:
        if isinstance(direction, int):
            direction, right = None, direction
        if right is None:
            raise TypeError("Range(left, direction, right): Range(7, 'downto', 0)")
        self.left = left
        self.right = right
        self.direction = (direction or ("to" if left <= right else "downto")).lower()

    def _range(self) -> range:
        return range(self.left, self.right + 1) if self.direction == "to" else range(self.left, self.right - 1, -1)

    def __len__(self) -> int:
        return len(self._range())

    def __iter__(self) -> Iterator[int]:
        return iter(self._range())

    def __contains__(self, item: object) -> bool:
        return item in self._range()

    def __getitem__(self, at: int) -> int:
        return self._range()[at]

    def index(self, value: int) -> int:
        """Returns the position of an index, from the left."""
        return self._range().index(value)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Range) and list(self) == list(other)

    def __hash__(self) -> int:
        return hash((self.left, self.direction, self.right))

    def __repr__(self) -> str:
        return f"Range({self.left}, '{self.direction}', {self.right})"


class Logic:
    """A digit: ``0``, ``1``, or one that no signal can have here (``X``, ``Z`` ...).

    >>> bool(Logic(1) & Logic("1"))
    True
    """

    _digit: str

    def __init__(self, value: Any = "X") -> None:
        if isinstance(value, Logic):
            self._digit = value._digit
            return
        text = str(int(value)) if isinstance(value, (bool, int)) or hasattr(value, "__index__") else str(value).upper()
        if len(text) != 1 or text not in _DIGITS:
            raise ValueError(f"{value!r} is no digit of a Logic: {', '.join(_DIGITS)}")
        self._digit = text

    @property
    def is_resolvable(self) -> bool:
        """Whether it is 0 or 1."""
        return self._digit in "01LH"

    def __bool__(self) -> bool:
        return bool(int(self))

    def __int__(self) -> int:
        if not self.is_resolvable:
            raise ValueError(f"Logic('{self._digit}') is neither 0 nor 1")
        return int(self._digit in "1H")

    def __index__(self) -> int:
        return int(self)

    def __str__(self) -> str:
        return self._digit

    def __repr__(self) -> str:
        return f"{type(self).__name__}('{self._digit}')"

    def __eq__(self, other: object) -> bool:
        try:
            return self._digit == Logic(other)._digit
        except ValueError:
            return False

    def __hash__(self) -> int:
        return hash(self._digit)

    def _with(self, other: Any, operation: Any, decided_by: int | None) -> Logic:
        a, b = self, other if isinstance(other, Logic) else Logic(other)
        if a.is_resolvable and b.is_resolvable:
            return type(self)(operation(int(a), int(b)))
        known = [int(x) for x in (a, b) if x.is_resolvable]
        return type(self)(decided_by) if decided_by is not None and decided_by in known else Logic("X")

    def __and__(self, other: Any) -> Logic:
        return self._with(other, int.__and__, 0)

    def __or__(self, other: Any) -> Logic:
        return self._with(other, int.__or__, 1)

    def __xor__(self, other: Any) -> Logic:
        return self._with(other, int.__xor__, None)

    __rand__, __ror__, __rxor__ = __and__, __or__, __xor__

    def __invert__(self) -> Logic:
        return type(self)(1 - int(self)) if self.is_resolvable else Logic("X")


class Bit(Logic):
    """A ``Logic`` that is 0 or 1."""

    def __init__(self, value: Any = 0) -> None:
        super().__init__(value)
        if self._digit not in "01":
            raise ValueError(f"{value!r} is no Bit: 0 or 1")


class AbstractArray:
    """The items of an array with a range; the base of `LogicArray` and `Array`."""

    range: Range

    @property
    def left(self) -> int:
        """The index of the first item."""
        return self.range.left

    @property
    def direction(self) -> str:
        """``"to"`` or ``"downto"``."""
        return self.range.direction

    @property
    def right(self) -> int:
        """The index of the last item."""
        return self.range.right

    def __iter__(self) -> Iterator[Any]:
        raise NotImplementedError

    def __contains__(self, item: object) -> bool:
        return any(own == item for own in self)

    def index(self, value: object) -> int:
        """Returns the index of the first item with a value.

        Raises
        ------
        ValueError
            If there is none.
        """
        for index, item in zip(self.range, self):
            if item == value:
                return index
        raise ValueError(f"{value!r} is not in {self!r}")

    def count(self, value: object) -> int:
        """Returns the number of items with a value."""
        return sum(item == value for item in self)

    def _at(self, index: int) -> int:
        if index not in self.range:
            raise IndexError(f"index {index} of {self.range}")
        return self.range.index(index)

    def _span(self, part: slice) -> tuple[slice, Range]:
        """Returns the positions of a slice, both of whose indices are included, and its range."""
        left = self.range.left if part.start is None else part.start
        right = self.range.right if part.stop is None else part.stop
        if part.step is not None:
            raise IndexError(f"[{left}:{right}:{part.step}]: a slice of {self.range} has no step")
        first, last = self._at(left), self._at(right)
        if first > last:
            raise IndexError(f"[{left}:{right}] has not the direction of {self.range}")
        return slice(first, last + 1), Range(left, self.range.direction, right)


AbstractMutableArray = AbstractArray


class LogicArray(AbstractArray):
    """Digits with a range: ``LogicArray("10X1")``, ``LogicArray(10, 4)``, ``LogicArray(10, Range(3, "downto", 0))``.

    Compares with numbers, strings and values of signals; indexed and sliced by its range.

    >>> LogicArray("1010")[3:2]
    LogicArray('10', Range(3, 'downto', 2))
    """

    _digits: str

    def __init__(
        self, value: Any = "", range: Range | int | None = None, width: int | None = None  # noqa: A002
    ) -> None:
        size = width if width is not None else len(range) if isinstance(range, Range) else range
        if isinstance(value, LogicArray):
            digits = value._digits
        elif isinstance(value, str):
            digits = "".join(str(Logic(digit)) for digit in value if digit != "_")
        elif hasattr(value, "__index__"):
            number = value.__index__()
            size = size or (len(value) if hasattr(value, "__len__") else max(number.bit_length(), 1))
            if not -(1 << (size - 1)) <= number < 1 << size:
                raise OverflowError(f"{number} does not fit {size} digits")
            digits = format(number & ((1 << size) - 1), f"0{size}b")
        elif isinstance(value, Iterable):
            digits = "".join(str(Logic(digit)) for digit in value)
        else:
            raise TypeError(f"a LogicArray is made of digits or a whole number, not of {value!r}")
        if size is not None and size != len(digits):
            raise ValueError(f"'{digits}' has {len(digits)} digits, not {size}")
        self._digits = digits
        self.range = range if isinstance(range, Range) else Range(len(digits) - 1, "downto", 0)

    @classmethod
    def from_unsigned(cls, value: int, range: Range | int) -> LogicArray:  # noqa: A002
        """Returns the digits of a non-negative number."""
        if value < 0:
            raise OverflowError(f"{value} is negative")
        return cls(value, range)

    @classmethod
    def from_signed(cls, value: int, range: Range | int) -> LogicArray:  # noqa: A002
        """Returns the digits of a number in two's complement."""
        size = len(range) if isinstance(range, Range) else range
        if not -(1 << (size - 1)) <= value < 1 << (size - 1):
            raise OverflowError(f"{value} does not fit {size} digits of two's complement")
        return cls(value, range)

    @classmethod
    def from_bytes(cls, value: bytes, range: Range | int | None = None, *, byteorder: str = "big") -> LogicArray:  # noqa: A002
        """Returns the digits of bytes."""
        number = int.from_bytes(value, "little" if byteorder == "little" else "big")
        return cls(number, 8 * len(value) if range is None else range)

    @property
    def is_resolvable(self) -> bool:
        """Whether all digits are 0 or 1."""
        return all(digit in "01LH" for digit in self._digits)

    def to_unsigned(self) -> int:
        """Returns the digits as an unsigned number."""
        if not self.is_resolvable:
            raise ValueError(f"'{self._digits}' has digits that are neither 0 nor 1")
        return int(self._digits.translate(str.maketrans("LH", "01")) or "0", 2)

    def to_signed(self) -> int:
        """Returns the digits as a number in two's complement."""
        number, size = self.to_unsigned(), len(self)
        return number - (1 << size) if size and number >> (size - 1) else number

    def to_bytes(self, *, byteorder: str = "big") -> bytes:
        """Returns the digits as bytes."""
        return self.to_unsigned().to_bytes((len(self) + 7) // 8, "little" if byteorder == "little" else "big")

    integer = property(to_unsigned, doc="The unsigned number.")
    signed_integer = property(to_signed, doc="The number in two's complement.")

    @property
    def binstr(self) -> str:
        """The digits as text, the leftmost first."""
        return self._digits

    def __getitem__(self, index: int | slice) -> Any:
        if isinstance(index, slice):
            positions, part = self._span(index)
            return LogicArray(self._digits[positions], part)
        return Logic(self._digits[self._at(index)])

    def __setitem__(self, index: int | slice, value: Any) -> None:
        positions, part = self._span(index if isinstance(index, slice) else slice(index, index))
        digits = str(Logic(value)) if len(part) == 1 else LogicArray(value, part)._digits
        self._digits = self._digits[: positions.start] + digits + self._digits[positions.stop :]

    def __len__(self) -> int:
        return len(self._digits)

    def __iter__(self) -> Iterator[Logic]:
        return (Logic(digit) for digit in self._digits)

    def __reversed__(self) -> Iterator[Logic]:
        return (Logic(digit) for digit in reversed(self._digits))

    def __str__(self) -> str:
        return self._digits

    def __repr__(self) -> str:
        return f"{type(self).__name__}('{self._digits}', {self.range})"

    def __int__(self) -> int:
        return self.to_unsigned()

    def __index__(self) -> int:
        return self.to_unsigned()

    def __bool__(self) -> bool:
        return any(digit in "1H" for digit in self._digits)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, str):
            return self._digits == other.upper().replace("_", "")
        if isinstance(other, LogicArray):
            return self._digits == other._digits
        if isinstance(other, Logic):
            return self._digits == str(other)
        if hasattr(other, "__index__"):
            return self.is_resolvable and self.to_unsigned() == other.__index__()
        if isinstance(other, (list, tuple)):
            return len(other) == len(self) and all(a == b for a, b in zip(self, other))
        return NotImplemented

    def __hash__(self) -> int:
        return hash(self.to_unsigned()) if self.is_resolvable else hash(self._digits)

    def _with(self, other: Any, operation: Any) -> LogicArray:
        other = LogicArray(other, len(self))
        return LogicArray([operation(a, b) for a, b in zip(self, other)], self.range)

    def __and__(self, other: Any) -> LogicArray:
        return self._with(other, Logic.__and__)

    def __or__(self, other: Any) -> LogicArray:
        return self._with(other, Logic.__or__)

    def __xor__(self, other: Any) -> LogicArray:
        return self._with(other, Logic.__xor__)

    __rand__, __ror__, __rxor__ = __and__, __or__, __xor__

    def __invert__(self) -> LogicArray:
        return LogicArray([~digit for digit in self], self.range)

    # Calculations return plain integers, as with the values of signals.

    def __lt__(self, other: Any) -> bool:
        return bool(self.to_unsigned() < int(other))

    def __le__(self, other: Any) -> bool:
        return bool(self.to_unsigned() <= int(other))

    def __gt__(self, other: Any) -> bool:
        return bool(self.to_unsigned() > int(other))

    def __ge__(self, other: Any) -> bool:
        return bool(self.to_unsigned() >= int(other))

    def __add__(self, other: Any) -> int:
        return self.to_unsigned() + int(other)

    def __sub__(self, other: Any) -> int:
        return self.to_unsigned() - int(other)

    def __rsub__(self, other: Any) -> int:
        return int(other) - self.to_unsigned()

    def __mul__(self, other: Any) -> int:
        return self.to_unsigned() * int(other)

    def __lshift__(self, other: Any) -> int:
        return self.to_unsigned() << int(other)

    def __rshift__(self, other: Any) -> int:
        return self.to_unsigned() >> int(other)

    __radd__, __rmul__ = __add__, __mul__


class Array(AbstractArray):
    """A fixed number of items of any kind, indexed and sliced by a range; without one from 0 on. Equal to another array, a list
    or a tuple with the same items from left to right.

    >>> Array([1, 2, 3], Range(2, "downto", 0))[2:1]
    Array([1, 2], Range(2, 'downto', 1))
    """

    def __init__(self, value: Iterable[Any], range: Range | int | None = None) -> None:  # noqa: A002
        self._items = list(value)
        size = len(self._items) if range is None else range
        self.range = Range(0, "to", size - 1) if isinstance(size, int) else size

    @property
    def range(self) -> Range:
        """The indices, from left to right; another range must have as many."""
        return self._range

    @range.setter
    def range(self, new: Range) -> None:
        if not isinstance(new, Range):
            raise TypeError(f"{new!r} is no range of an Array: Range(3, 'downto', 0)")
        if len(new) != len(self._items):
            raise ValueError(f"{new} has {len(new)} indices, not {len(self._items)}")
        self._range = new

    def __getitem__(self, index: int | slice) -> Any:
        if isinstance(index, slice):
            positions, part = self._span(index)
            return Array(self._items[positions], part)
        return self._items[self._at(index)]

    def __setitem__(self, index: int | slice, value: Any) -> None:
        if not isinstance(index, slice):
            self._items[self._at(index)] = value
            return
        positions, part = self._span(index)
        items = list(value)
        if len(items) != len(part):
            raise ValueError(f"{len(items)} items for {part}, which has {len(part)} indices")
        self._items[positions] = items

    def __len__(self) -> int:
        return len(self._items)

    def __iter__(self) -> Iterator[Any]:
        return iter(self._items)

    def __reversed__(self) -> Iterator[Any]:
        return iter(self._items[::-1])

    def __eq__(self, other: object) -> bool:
        if isinstance(other, (Array, list, tuple)):
            return self._items == list(other)
        return NotImplemented

    # It can be changed.
    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"Array({self._items!r}, {self.range})"


_list_of_array = ArrayHandle.value


def index_arrays_as_declared(yes: bool) -> None:
    """Sets whether the value of a handle of an array is an `Array` with the declared range, as in cocotb 2, or a list.

    >>> index_arrays_as_declared(True)
    """
    ArrayHandle.value = property(_array_of, _list_of_array.__set__) if yes else _list_of_array


def _array_of(handle: ArrayHandle) -> Array:
    return _with_ranges(_list_of_array.__get__(handle), handle)


def _with_ranges(items: list[Any], handle: ArrayHandle) -> Array:
    """Returns the items of an array, and of the arrays in it, with their ranges."""
    left, right = handle._range
    if isinstance(items[0], list):
        row: Any = handle[left]  # all rows have the same range
        items = [_with_ranges(item, row) for item in items]
    return Array(items, Range(left, right))


def concat(a: Any, b: Any) -> LogicArray:
    """Returns two values, one after the other.

    >>> concat(LogicArray("10"), LogicArray("01"))
    LogicArray('1001', Range(3, 'downto', 0))
    """
    return LogicArray(str(a) + str(b))
