"""``cocotb.handle``: names for annotations and ``isinstance``, and kinds of writes.

>>> dut.data.value = Immediate(5)
>>> isinstance(dut.data, LogicArrayObject)
"""

from __future__ import annotations

import enum
from collections.abc import Callable
from typing import Any

from .. import hierarchy
from .._core import ArrayHandle, Bits, Element, Handle, RealHandle, TextHandle
from ..writes import Deposit, Force, Freeze, Immediate, Release
from .types import Logic, LogicArray

__all__ = [
    "ArrayObject",
    "ConstantObject",
    "Deposit",
    "EnumObject",
    "Force",
    "Freeze",
    "GPIDiscovery",
    "HierarchyArrayObject",
    "HierarchyObject",
    "Immediate",
    "IntegerObject",
    "Logic",
    "LogicArray",
    "LogicArrayObject",
    "LogicObject",
    "ModifiableObject",
    "NonConstantObject",
    "NonHierarchyIndexableObject",
    "NonHierarchyObject",
    "PackedObject",
    "RealObject",
    "RegionObject",
    "Release",
    "SimHandle",
    "SimHandleBase",
    "StringObject",
    "ValueObjectBase",
]


class _Kind(type):
    """A class that matches some of the handles, for ``isinstance`` and annotations; it has no instances."""

    _check: Callable[[Any], bool]

    def __instancecheck__(cls, instance: object) -> bool:
        return bool(cls._check(instance))

    def __getitem__(cls, _parameters: Any) -> _Kind:
        return cls

    def __call__(cls, *_: object) -> Any:
        raise TypeError(f"{cls.__name__} matches handles of the design; a bench cannot create one")


def _kind(name: str, text: str, check: Callable[[Any], bool]) -> Any:
    return _Kind(name, (), {"__doc__": text, "__module__": __name__, "_check": staticmethod(check)})


_VALUES = (Handle, ArrayHandle, Element, Bits, RealHandle, TextHandle, hierarchy.Constant)


def _is_logic(handle: Any) -> bool:
    return isinstance(handle, (Handle, Bits, Element)) and len(handle) == 1


def _is_vector(handle: Any) -> bool:
    return isinstance(handle, (Handle, Bits, Element)) and len(handle) > 1


def _is_array_of_instances(handle: Any) -> bool:
    return isinstance(handle, hierarchy.Hierarchy) and all(name.isdigit() for name in handle._children) and len(handle) > 0


def _is_instance(handle: Any) -> bool:
    return isinstance(handle, hierarchy.Hierarchy) and not _is_array_of_instances(handle)


def _is_integer(handle: Any) -> bool:
    return isinstance(handle, hierarchy.Constant) and isinstance(handle.value, int)


def _is_real(handle: Any) -> bool:
    return isinstance(handle, RealHandle) or isinstance(handle, hierarchy.Constant) and isinstance(handle.value, float)


def _is_string(handle: Any) -> bool:
    return isinstance(handle, TextHandle) or isinstance(handle, hierarchy.Constant) and isinstance(handle.value, str)


SimHandleBase = _kind("SimHandleBase", "Any handle.", lambda h: isinstance(h, (*_VALUES, hierarchy.Hierarchy)))
ValueObjectBase = _kind("ValueObjectBase", "A handle with a value.", lambda h: isinstance(h, _VALUES))
NonHierarchyObject = NonConstantObject = ValueObjectBase
ModifiableObject = _kind("ModifiableObject", "A signal.", lambda h: isinstance(h, _VALUES[:-1]))
LogicObject = _kind("LogicObject", "A signal of one bit.", _is_logic)
LogicArrayObject = _kind("LogicArrayObject", "A signal of several bits.", _is_vector)
PackedObject = LogicArrayObject
EnumObject = _kind("EnumObject", "A signal of an enumeration's type.", lambda h: getattr(h, "_type", "") == "GPI_ENUM")
IntegerObject = _kind("IntegerObject", "A parameter that is a whole number.", _is_integer)
RealObject = _kind("RealObject", "A `real`, or a parameter that is one.", _is_real)
StringObject = _kind("StringObject", "A `string`, or a parameter that is one.", _is_string)
ConstantObject = hierarchy.Constant
ArrayObject = NonHierarchyIndexableObject = ArrayHandle
HierarchyObject = _kind("HierarchyObject", "An instance.", _is_instance)
HierarchyArrayObject = _kind("HierarchyArrayObject", "Instances with indices, such as a generate block's.", _is_array_of_instances)
RegionObject = _kind("RegionObject", "An instance, or several.", lambda h: isinstance(h, hierarchy.Hierarchy))


def SimHandle(handle: Any, path: str | None = None) -> Any:
    """Returns the handle itself."""
    return handle


class GPIDiscovery:
    """The ways to look up a name in cocotb; here all names are known, so they have no effect."""

    AUTO = 0
    NATIVE = 1


class _Limits(enum.IntEnum):
    """The range of the numbers that a signal takes; packages import it although it is not public."""

    SIGNED_NBIT = 1
    UNSIGNED_NBIT = 2
    VECTOR_NBIT = 3


# In cocotb, whether writes are left to the simulator to order. Here the engine orders them.
_trust_inertial = False
