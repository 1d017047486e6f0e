"""Deprecation warnings for names of cocotb 1, with the advice of cocotb 2; active under the alias for cocotb 2.

Python shows a ``DeprecationWarning`` where pytest runs and in the main program; ``-W error::DeprecationWarning`` makes it an
error.
"""

from __future__ import annotations

import functools
import warnings
from typing import Any

from . import _core

__all__ = ["ADVICE", "advise", "switch"]

_CAST = "`int(handle)` casts have been deprecated. Use `int(handle.value)` instead."
_UNITS = "The 'units' argument has been renamed to 'unit'."
_NAME = "The 'name' argument will be removed in a future release."
_IMMEDIATE = "Use `handle.set(Immediate(...))` or `handle.value = Immediate(...)` instead."

ADVICE: dict[str, str] = {
    "Timer(units)": _UNITS,
    "Clock(units)": _UNITS,
    "get_sim_time(units)": _UNITS,
    "get_sim_steps(units)": _UNITS,
    "get_time_from_sim_steps(units)": _UNITS,
    "Event(name)": _NAME,
    "Event.set(data)": "The data field will be removed in a future release.",
    "Lock(name)": _NAME,
    "Join": "Using `task` directly is preferred to `Join(task)` in all situations where the latter could be used.",
    "start": "Use ``cocotb.start_soon`` instead.",
    "TestFactory": "TestFactory is deprecated, use `@cocotb.parametrize` instead",
    "result.TestSuccess": "`raise TestSuccess` is deprecated. Use `cocotb.end_test` or `pytest.skip` instead.",
    "result.SimFailure": "SimFailure was moved to `cocotb.regression`.",
    "result.SimTimeoutError": "SimTimeoutError was moved from `cocotb.result` to `cocotb.triggers`.",
    "Task.kill": "`task.kill()` is deprecated in favor of `task.cancel()`",
    "Task.join": "Using `task` directly is preferred to `task.join()` in all situations where the latter could be used.",
    "Value.binstr": "`logic_array.binstr` getter is deprecated. Use `str(logic_array)` instead.",
    "Value.integer": "`logic_array.integer` getter is deprecated. Use `logic_array.to_unsigned()` instead.",
    "Value.signed_integer": "`logic_array.signed_integer` getter is deprecated. Use `logic_array.to_signed()` instead.",
    "Value.buff": '`logic_array.buff` getter is deprecated. Use `logic_array.to_bytes(byteorder="big")` instead.',
    "Handle.__int__": _CAST,
    "Element.__int__": _CAST,
    "Bits.__int__": _CAST,
    "RealHandle.__float__": "`float(handle)` casts have been deprecated. Use `float(handle.value)` instead.",
    **{
        f"{kind}.setimmediatevalue": _IMMEDIATE
        for kind in ("Handle", "Element", "ArrayHandle", "RealHandle", "TextHandle")
    },
}
"""The advice for each deprecated use: a class and its method or property, or a function and its argument."""

_on = False
# The methods that `switch` has replaced, by class and name.
_originals: dict[tuple[type, str], Any] = {}


def advise(what: str, stacklevel: int = 3) -> None:
    """Warns, if such warnings are on, that the caller's caller used ``what``, an entry of `ADVICE`.

    >>> advise("Lock(name)")
    """
    if _on:
        warnings.warn(ADVICE[what], DeprecationWarning, stacklevel=stacklevel)


def switch(on: bool) -> None:
    """Switches the warnings on or off. Off, the original methods are restored, which costs nothing.

    >>> switch(False)
    """
    global _on
    from .cocotb.types import LogicArray

    _on = on
    _core.advise_units(on)
    for (owner, name), original in _originals.items():
        setattr(owner, name, original)
    _originals.clear()
    if not on:
        return
    for what in ADVICE:
        kind, _, name = what.partition(".")
        owners = [owner for owner in (getattr(_core, kind, None), LogicArray if kind == "Value" else None) if owner]
        for owner in owners if name else []:
            if name in owner.__dict__:
                original = _originals[owner, name] = owner.__dict__[name]
                setattr(owner, name, _warning(what, original))


def _warning(what: str, original: Any) -> Any:
    if not callable(original):
        get = original.__get__

        def read(self: Any) -> Any:
            advise(what)
            return get(self)

        return property(read, doc=original.__doc__)

    @functools.wraps(original)
    def call(self: Any, *arguments: Any) -> Any:
        advise(what)
        return original(self, *arguments)

    return call
