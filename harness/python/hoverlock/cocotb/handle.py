"""``cocotb.handle``: the names that benches use for annotations."""

from .._core import ArrayHandle, Handle
from ..hierarchy import Hierarchy

__all__ = [
    "ArrayObject",
    "HierarchyArrayObject",
    "HierarchyObject",
    "LogicArrayObject",
    "LogicObject",
    "ModifiableObject",
    "NonHierarchyObject",
    "SimHandleBase",
]

HierarchyObject = HierarchyArrayObject = Hierarchy
SimHandleBase = Hierarchy | Handle | ArrayHandle
ModifiableObject = NonHierarchyObject = LogicObject = LogicArrayObject = Handle
ArrayObject = ArrayHandle
