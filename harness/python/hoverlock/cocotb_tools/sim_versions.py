"""``cocotb_tools.sim_versions``: versions of simulators that can be compared.

>>> VerilatorVersion("5.006 2023-01-22") < VerilatorVersion("5.048")
True
"""

from __future__ import annotations

import re
from functools import total_ordering
from itertools import zip_longest

__all__ = [
    "ActivehdlVersion",
    "CvcVersion",
    "GhdlVersion",
    "IcarusVersion",
    "IusVersion",
    "ModelsimVersion",
    "NvcVersion",
    "QuestaVersion",
    "RivieraVersion",
    "VcsVersion",
    "VerilatorVersion",
    "XceliumVersion",
]


@total_ordering
class _Version:
    """A version as its simulator prints it. Its first word that begins with a digit counts: numbers as numbers."""

    def __init__(self, text: str) -> None:
        self.text = text
        first = next((word for word in text.replace("(", " ").split() if word[0].isdigit()), "")
        parts: list[int | str] = [int(part) if part.isdigit() else part for part in re.findall(r"\d+|[a-zA-Z]+", first)]
        self.parts = parts

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return not self < other and not other < self

    def __lt__(self, other: object) -> bool:
        if not isinstance(other, _Version) or type(other) is not type(self):
            return NotImplemented
        for own, its in zip_longest(self.parts, other.parts, fillvalue=0):
            if own != its:
                # A letter comes before any number: 10.5b is older than 10.5.1.
                return own < its if type(own) is type(its) else isinstance(own, str)  # type: ignore[operator]
        return False

    def __hash__(self) -> int:
        return hash(type(self))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.text!r})"


class ActivehdlVersion(_Version):
    """A version of Active-HDL."""


class CvcVersion(_Version):
    """A version of CVC."""


class GhdlVersion(_Version):
    """A version of GHDL."""


class IcarusVersion(_Version):
    """A version of Icarus Verilog."""


class IusVersion(_Version):
    """A version of Incisive."""


class ModelsimVersion(_Version):
    """A version of ModelSim."""


class NvcVersion(_Version):
    """A version of NVC."""


class QuestaVersion(_Version):
    """A version of Questa."""


class RivieraVersion(_Version):
    """A version of Riviera-PRO."""


class VcsVersion(_Version):
    """A version of VCS."""


class VerilatorVersion(_Version):
    """A version of Verilator."""


class XceliumVersion(_Version):
    """A version of Xcelium."""
