"""``cocotb_tools.sim_versions``: versions of Verilator that can be compared. Those of other simulators are compared alike.

>>> VerilatorVersion("5.006 2023-01-22") < VerilatorVersion("5.048")
True
"""

from __future__ import annotations

import re
from functools import total_ordering

__all__ = [
    "ActivehdlVersion", "CvcVersion", "DSimVersion", "GhdlVersion", "IcarusVersion", "IusVersion", "ModelsimVersion", "NvcVersion", "QuestaVersion",
    "RivieraVersion", "VcsVersion", "VerilatorVersion", "XceliumVersion",
]  # fmt: skip


@total_ordering
class VerilatorVersion:
    """A version as Verilator prints it. The numbers of its first word that begins with a digit are compared.

    >>> VerilatorVersion("Verilator 5.006 2023-01-22") == VerilatorVersion("5.6")
    True
    """

    def __init__(self, text: str) -> None:
        self.text = text
        number = re.search(r"(?<!\S)\d[\d.]*", text)
        self.parts = [int(part) for part in re.findall(r"\d+", number[0])] if number else []
        while self.parts and self.parts[-1] == 0:
            self.parts.pop()

    def __eq__(self, other: object) -> bool:
        return self.parts == other.parts if isinstance(other, VerilatorVersion) else NotImplemented

    def __lt__(self, other: object) -> bool:
        return self.parts < other.parts if isinstance(other, VerilatorVersion) else NotImplemented

    def __hash__(self) -> int:
        return hash(tuple(self.parts))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.text!r})"


# The classes for other simulators: benches create them for comparisons that they make on those simulators only.
ActivehdlVersion = CvcVersion = DSimVersion = GhdlVersion = IcarusVersion = ModelsimVersion = VerilatorVersion
IusVersion = NvcVersion = QuestaVersion = RivieraVersion = VcsVersion = XceliumVersion = VerilatorVersion
