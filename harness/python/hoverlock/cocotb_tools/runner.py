"""``cocotb_tools.runner``.

>>> from hoverlock.cocotb_tools.runner import get_runner
"""

from ..cocotb.runner import (
    VHDL,
    ActiveHDL,
    Dsim,
    Ghdl,
    Icarus,
    Nvc,
    Questa,
    QuestaQIS,
    Riviera,
    Runner,
    Vcs,
    Verilator,
    VerilatorControlFile,
    Verilog,
    Xcelium,
    get_abs_path,
    get_results,
    get_runner,
)

__all__ = [
    "VHDL", "ActiveHDL", "Dsim", "Ghdl", "Icarus", "Nvc", "Questa", "QuestaQIS", "Riviera", "Runner", "Vcs", "Verilator",
    "VerilatorControlFile", "Verilog", "Xcelium", "get_abs_path", "get_results", "get_runner",
]  # fmt: skip
