"""The design as a tree of attributes: ports, internals, parameters and instances."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from ._core import ArrayHandle, Handle, HierarchyBase, RealHandle, Simulation, TextHandle

if TYPE_CHECKING:
    import logging

__all__ = ["Constant", "Hierarchy", "TypedHierarchy"]


hidden_asked_for: list[str] = []
"""The internal signals that benches asked for although the model does not give access to them, also those of a `hasattr`. The
runner clears it."""

lists_hidden = False
"""Whether `dir` of the top lists internal signals that are not accessible. The alias for cocotb sets it: packages look there for
the signals of a bus, and the runner needs to know that they want one."""


class Constant:
    """A parameter of the design; its value is an integer, a `float` or a string.

    >>> dut.WIDTH.value
    8
    """

    def __init__(self, name: str, value: float | str) -> None:
        self._name = name.rpartition(".")[2]
        self._path = name
        self._value = value

    @property
    def _type(self) -> str:
        """The kind of value by cocotb's name."""
        kinds = {int: "GPI_INTEGER", float: "GPI_REAL", str: "GPI_STRING"}
        return kinds[type(self._value)]

    @property
    def _log(self) -> logging.Logger:
        from .log import log

        return log.getChild(self._name)

    @property
    def value(self) -> Any:
        """The value, which was set when the design was built."""
        return self._value

    def __int__(self) -> int:
        return int(self._value)

    def __index__(self) -> int:
        return int(self._value)

    def __eq__(self, other: object) -> bool:
        return self._value == (other._value if isinstance(other, Constant) else other)

    def __hash__(self) -> int:
        return hash(self._value)

    def __repr__(self) -> str:
        return f"<parameter {self._name} = {self._value!r}>"


class TypedHierarchy(HierarchyBase):
    """A level of the design with the names known to type checkers: the base of the classes in a stub.

    >>> class Counter(TypedHierarchy):
    ...     clk: Handle
    """

    _name: str
    _path: str
    # Path below the top module; empty for the top.
    _below: str
    _simulation: Simulation
    _children: dict[str, Any]
    # Signals that the model does not make accessible, where `dir` lists them; known only for the top.
    _hidden: tuple[str, ...] = ()
    _type = "GPI_MODULE"
    # Name of the module; known only for the top.
    _def_name = ""

    def __init__(self, name: str, below: str, simulation: Simulation, top: str = "") -> None:
        path = f"{top}.{below}" if top and below else top or below
        self.__dict__.update(_name=name, _path=path, _below=below, _simulation=simulation, _children={})

    @property
    def _log(self) -> logging.Logger:
        from .log import log

        return log.getChild(self._name)

    def __setattr__(self, name: str, value: Any) -> None:
        if name in self._children:
            raise TypeError(f"to write a signal, assign to its value: {self._name}.{name}.value = {value!r}")
        if not name.startswith("_"):
            missing: AttributeError = self._missing(name)
            raise missing
        self.__dict__[name] = value

    def _missing(self, name: str) -> AttributeError:
        path = f"{self._below}.{name}" if self._below else name
        error: AttributeError = self._simulation.no_such_signal(path)
        if "internals=" in str(error):
            hidden_asked_for.append(path)
        return error

    def __getitem__(self, key: Any) -> Any:
        child = self._children.get(str(key))
        if child is None:
            raise self._missing(f"[{key}]" if isinstance(key, int) else str(key))
        return child

    def _id(self, name: str, extended: bool = True) -> Any:
        """Returns a child by its name; for names that cannot be written as attributes."""
        return self[name.strip("\\ ")]

    def _discover_all(self) -> None:
        """Does nothing, because all children are known. Present because cocotb has it."""

    def __contains__(self, name: str) -> bool:
        return name in self._children

    def __iter__(self) -> Iterator[Any]:
        return iter(self._children.values())

    def __len__(self) -> int:
        return len(self._children)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._children, *self._hidden]

    def __repr__(self) -> str:
        return f"<Hierarchy {self._below or self._name}>"

    def _add(self, name: str, child: Any) -> None:
        self._children[name] = child
        self.__dict__[name] = child


class Hierarchy(TypedHierarchy):
    """The top module or an instance in it: ``dut.count`` is a signal, ``dut.core`` an instance, ``dut.gen[0]`` one of
    several.

    >>> for child in dut.core:
    ...     print(child._name)
    >>> assert "state" in dut.core
    """

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...


_STEP = re.compile(r"[^.\[\]$]+")


def build(
    top: str, simulation: Simulation, constants: Iterable[tuple[str, int | str]] = (), names: Iterable[str] = ()
) -> Hierarchy:
    """Builds the tree of a simulation's handles. A port named ``video$data`` is also ``video.data``. `dir` of the top lists
    those of ``names`` too that are in it, accessible or not."""
    root = Hierarchy(top, "", simulation, top)
    root.__dict__["_def_name"] = top
    for name, handle in simulation.handles():
        _place(root, name, handle, simulation)
    instances = {path for path, _ in _instances(root)}
    for name, value in constants:
        # Parameters of instances without accessible signals are left out: the instance would have no other child.
        if name.rpartition(".")[0] in instances:
            _place(root, name, Constant(name, value), simulation)
    root.__dict__["_hidden"] = tuple(name for name in names if "." not in name and name not in root)
    return root


def _instances(node: Hierarchy) -> Iterator[tuple[str, Hierarchy]]:
    yield node._below, node
    for child in node:
        if isinstance(child, Hierarchy):
            yield from _instances(child)


def _place(root: Hierarchy, name: str, handle: Handle | ArrayHandle | RealHandle | TextHandle | Constant, simulation: Simulation) -> None:
    if "$" in name:
        root._add(name, handle)
    found = list(_STEP.finditer(name))
    steps = [match[0] for match in found]
    node = root
    for step, match in zip(steps[:-1], found):
        child = node._children.get(step)
        if child is None:
            # The path in the engine's notation: `lane[2].u_add`.
            end = match.end() + (name[match.end() : match.end() + 1] == "]")
            child = Hierarchy(step, name[:end], simulation, root._name)
            node._add(step, child)
        if not isinstance(child, Hierarchy):
            return  # a signal and an instance have the same name: the signal keeps it
        node = child
    if steps and steps[-1] not in node._children:
        node._add(steps[-1], handle)
