"""``cocotb_tools.config``."""

from ..cocotb.config import lib_name, lib_name_path, libs_dir, makefiles_dir, pygpi_entry_point, share_dir

__all__ = ["lib_name", "lib_name_path", "libs_dir", "makefiles_dir", "pygpi_entry_point", "share_dir"]
