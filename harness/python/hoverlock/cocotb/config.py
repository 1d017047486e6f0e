"""``cocotb.config`` and ``cocotb_tools.config``: the folders of makefiles. There are no libraries for simulators.

>>> print(makefiles_dir)
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import NoReturn

from ..errors import HoverlockError

__all__ = ["lib_name", "lib_name_path", "libs_dir", "makefiles_dir", "pygpi_entry_point", "share_dir"]

share_dir = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
"""The folder of the package."""


class _Folder(str):
    """A path that is also a function: an attribute in cocotb 1, a function in cocotb 2."""

    def __call__(self) -> Path:
        return Path(self)


makefiles_dir = _Folder(os.path.join(share_dir, "makefiles"))
"""The folder of ``Makefile.sim``."""


def _no_library(*_arguments: object) -> NoReturn:
    raise HoverlockError("there are no VPI, VHPI or FLI libraries here: benches run on Verilator in the same process")


libs_dir = lib_name = lib_name_path = pygpi_entry_point = _no_library
