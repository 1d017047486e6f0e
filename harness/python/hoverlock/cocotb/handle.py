"""``cocotb.handle``: names for annotations, and kinds of writes.

>>> dut.data.value = Immediate(5)
"""

from __future__ import annotations

from typing import Any

from .._core import ArrayHandle, Element, Handle
from ..hierarchy import Constant, Hierarchy

__all__ = [
    "ArrayObject",
    "ConstantObject",
    "Deposit",
    "EnumObject",
    "Force",
    "Freeze",
    "HierarchyArrayObject",
    "HierarchyObject",
    "Immediate",
    "IntegerObject",
    "LogicArrayObject",
    "LogicObject",
    "ModifiableObject",
    "NonHierarchyIndexableObject",
    "NonHierarchyObject",
    "Release",
    "SimHandleBase",
    "ValueObjectBase",
]

HierarchyObject = HierarchyArrayObject = Hierarchy
SimHandleBase = Hierarchy | Handle | ArrayHandle | Element | Constant
ModifiableObject = NonHierarchyObject = LogicObject = LogicArrayObject = EnumObject = IntegerObject = Handle
ValueObjectBase = Handle | ArrayHandle | Element | Constant
ArrayObject = NonHierarchyIndexableObject = ArrayHandle
ConstantObject = Constant


class Deposit:
    """A plain write."""

    def __init__(self, value: Any) -> None:
        self.value = value

    def __index__(self) -> int:
        return int(self.value, 2) if isinstance(self.value, str) else int(self.value.__index__())


class Immediate(Deposit):
    """A plain write: there are no delta cycles here."""


class _Refused:
    def __init__(self, *_: object) -> None:
        raise NotImplementedError(
            f"{type(self).__name__}: a model's own assignments cannot be overridden; see 'Coming from cocotb'"
        )


class Force(_Refused):
    """Not supported: raises ``NotImplementedError``."""


class Freeze(_Refused):
    """Not supported: raises ``NotImplementedError``."""


class Release(_Refused):
    """Not supported: raises ``NotImplementedError``."""
