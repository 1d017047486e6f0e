"""The design as Python sees it: ports, internals and instances as attributes."""

from __future__ import annotations

import logging
import re
from collections.abc import Iterator
from typing import Any

from ._core import ArrayHandle, Handle, HierarchyBase, Simulation
from .log import log

__all__ = ["Hierarchy"]


class Hierarchy(HierarchyBase):
    """The top module or an instance in it: ``dut.count`` is a signal, ``dut.core`` an instance, ``dut.gen[0]`` one of
    several."""

    _name: str
    _path: str

    def __init__(self, name: str, path: str, simulation: Simulation) -> None:
        self.__dict__.update(_name=name, _path=path, _simulation=simulation, _children={})

    @property
    def _log(self) -> logging.Logger:
        return log.getChild(self._name)

    def __setattr__(self, name: str, value: Any) -> None:
        if name in self._children:
            raise TypeError(f"to write a signal, assign to its value: {self._name}.{name}.value = {value!r}")
        if not name.startswith("_"):
            missing: AttributeError = self._missing(name)
            raise missing
        self.__dict__[name] = value

    def _missing(self, name: str) -> AttributeError:
        path = f"{self._path}.{name}" if self._path else name
        return self._simulation.no_such_signal(path)  # type: ignore[no-any-return]

    def __getitem__(self, key: Any) -> Any:
        child = self._children.get(str(key))
        if child is None:
            raise self._missing(f"[{key}]" if isinstance(key, int) else str(key))
        return child

    def __contains__(self, name: str) -> bool:
        return name in self._children

    def __iter__(self) -> Iterator[Any]:
        return iter(self._children.values())

    def __len__(self) -> int:
        return len(self._children)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._children]

    def __repr__(self) -> str:
        return f"<Hierarchy {self._path or self._name}>"

    def _add(self, name: str, child: Any) -> None:
        self._children[name] = child
        self.__dict__[name] = child


_STEP = re.compile(r"[^.\[\]$]+")


def build(top: str, simulation: Simulation) -> Hierarchy:
    """The tree of a simulation's handles. A port written ``video$data`` is also ``video.data``."""
    root = Hierarchy(top, "", simulation)
    for name, handle in simulation.handles():
        _place(root, name, handle, simulation)
    return root


def _place(root: Hierarchy, name: str, handle: Handle | ArrayHandle, simulation: Simulation) -> None:
    if "$" in name:
        root._add(name, handle)
    steps = _STEP.findall(name)
    node, path = root, ""
    for step in steps[:-1]:
        path = f"{path}.{step}" if path else step
        child = node._children.get(step)
        if child is None:
            child = Hierarchy(step, path, simulation)
            node._add(step, child)
        if not isinstance(child, Hierarchy):
            return  # a signal and an instance of one name: the signal was there first
        node = child
    if steps and steps[-1] not in node._children:
        node._add(steps[-1], handle)
