"""Lets `import cocotb` import hoverlock's alias where cocotb is not installed, or where the environment variable
HOVERLOCK_AS_COCOTB is 1, so that benches, packages and scripts of the runner need no change.

Python loads this module at each start (`hoverlock_cocotb.pth`), so it loads nothing itself. For pytest, which would warn that
it cannot rewrite a module that is loaded: PYTEST_DONT_REWRITE.
"""

import sys

# `cocotb_test.simulator` imports cocotb in another way in each of its versions.
_NAMES = ("cocotb", "cocotb_tools", "cocotb_test", "cocotb_test.simulator")


class _Finder:
    """A finder that installs the alias at the first import of cocotb."""

    def find_spec(self, fullname, path=None, target=None):
        if fullname not in _NAMES:
            return None
        import os
        from importlib.machinery import PathFinder

        chosen = os.environ.get("HOVERLOCK_AS_COCOTB", "")
        if chosen == "0" or chosen != "1" and PathFinder.find_spec("cocotb") is not None:
            return None
        sys.meta_path.remove(self)
        from hoverlock import as_cocotb

        as_cocotb.install()
        return as_cocotb.find_spec(fullname)


sys.meta_path.insert(0, _Finder())
