"""``cocotb._base_triggers``: triggers by the place that they have in cocotb 2."""

from .triggers import Event, Lock, NullTrigger, Trigger

__all__ = ["Event", "Lock", "NullTrigger", "Trigger", "_InternalEvent"]


class _InternalEvent(Event):
    """An event that belongs to another object; cocotb's own tests use it."""

    def __init__(self, parent: object) -> None:
        super().__init__()
        self.parent = parent
