"""The alias: ``import cocotb``, also in packages such as ``cocotbext.axi``, imports this module's names.

    pytest -p hoverlock.as_cocotb test_adder.py
    python -m hoverlock --as-cocotb test_adder.py --hoverlock-source adder.v --hoverlock-top adder

Where cocotb is not installed, the first `import cocotb` of any program installs the alias (`hoverlock_cocotb.py`). Where it
is, programs that do not use the alias import cocotb as before; HOVERLOCK_AS_COCOTB=1 makes all of them use it.

>>> import hoverlock
>>> hoverlock.as_cocotb()
>>> import cocotb
>>> from cocotbext.axi import AxiStreamSource
"""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Sequence
from types import CodeType, ModuleType
from typing import TYPE_CHECKING, Any, cast

from .errors import HoverlockError

if TYPE_CHECKING:
    # Loading these takes milliseconds, and only the alias needs them.
    from importlib.abc import Loader
    from importlib.machinery import ModuleSpec

__all__ = ["find_spec", "install"]

VERSIONS = {"1.9": "1.9.2", "2.1": "2.1.0"}
"""The versions of cocotb that the alias can follow, and the value of ``cocotb.__version__``."""

VERSION_HELP = "the version of cocotb that the alias follows where versions differ (default: 2.1)"

_NAMES = {"cocotb": "hoverlock.cocotb", "cocotb_tools": "hoverlock.cocotb_tools"}
# cocotb-test, if it is installed, stays as it is but for the module that starts simulators: its plug-in of pytest is loaded first.
_STARTER = "cocotb_test.simulator"
# The replacement of digits other than 0 and 1, for each value of the variable COCOTB_RESOLVE_X.
_UNKNOWN = {"ZEROS": "zeros", "ONES": "ones", "RANDOM": "random", "WEAK": "weak", "VALUE_ERROR": "error", "ERROR": "error"}


class _Loader:
    """A loader that returns a module that is already loaded."""

    def __init__(self, module: ModuleType) -> None:
        self.module = module
        self.own = module.__spec__

    def create_module(self, _spec: ModuleSpec) -> ModuleType:
        return self.module

    def exec_module(self, module: ModuleType) -> None:
        # The import system has replaced the specification by that of the alias.
        module.__spec__ = self.own

    def get_code(self, _fullname: str) -> CodeType | None:
        """Returns the code of the module, which `python -m cocotb_tools.combine_results` runs."""
        from importlib.abc import InspectLoader

        loader = self.own and self.own.loader
        return loader.get_code(self.module.__name__) if isinstance(loader, InspectLoader) else None


class _Finder:
    """A finder that finds ``cocotb.triggers`` as ``hoverlock.cocotb.triggers``."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        head, dot, tail = fullname.partition(".")
        if head == "cocotb_test":
            return _of_cocotb_test(fullname)
        if head not in _NAMES:
            return None
        # After the check of the name, because these imports call this finder too.
        from importlib.util import find_spec

        own = _NAMES[head] + dot + tail
        if find_spec(own) is None:
            # An error, because the finders after this one would load the same file a second time.
            raise ModuleNotFoundError(f"No module named '{fullname}' in hoverlock; see 'Coming from cocotb'", name=fullname)
        return _spec_of(fullname, own)


def find_spec(fullname: str) -> ModuleSpec | None:
    """Returns the specification that the alias has for a module, or None.

    >>> find_spec("cocotb.triggers")
    """
    return _Finder().find_spec(fullname)


def _spec_of(fullname: str, own: str) -> ModuleSpec:
    """Returns the specification of a module here by another name."""
    from importlib.machinery import ModuleSpec

    module = importlib.import_module(own)
    loader = cast("Loader", _Loader(module))
    return ModuleSpec(fullname, loader, origin=module.__file__, is_package=hasattr(module, "__path__"))


def _of_cocotb_test(fullname: str) -> ModuleSpec | None:
    """Returns the specification of a module of cocotb-test, or None for those that are found where they are installed."""
    from importlib.machinery import PathFinder

    if fullname != _STARTER and (fullname != "cocotb_test" or PathFinder.find_spec(fullname) is not None):
        return None
    return _spec_of(fullname, f"hoverlock.{fullname}")


def install(version: str | None = None) -> None:
    """Makes ``import cocotb`` and ``import cocotb_tools`` import this module's names, from now on.

    Parameters
    ----------
    version : "1.9" or "2.1", optional
        The version to follow where versions differ; ``cocotb.__version__`` has it. Default: the environment
        variable ``HOVERLOCK_COCOTB``, or "2.1".

    Raises
    ------
    ValueError
        If there is no such version.
    HoverlockError
        If cocotb itself was imported before.

    >>> install("1.9")
    >>> import cocotb
    >>> cocotb.__version__
    '1.9.2'
    """
    asked = version or os.environ.get("HOVERLOCK_COCOTB") or "2.1"
    if asked not in VERSIONS:
        raise ValueError(f"no version '{asked}' of cocotb's names: {' or '.join(VERSIONS)}")
    import logging

    from . import _core, cocotb, deprecated, hierarchy, unknown, writes
    from .cocotb import types

    for name in (*_NAMES, _STARTER):
        loaded = sys.modules.get(name)
        if loaded is None or str(loaded.__name__).startswith("hoverlock."):
            continue
        if name == _STARTER and getattr(loaded.__spec__, "_initializing", False):
            # It is being imported, and has just asked for cocotb: the import returns what it finds here at its end.
            sys.modules[name] = importlib.import_module(f"hoverlock.{name}")
            continue
        raise HoverlockError(f"{name} was imported before hoverlock.as_cocotb(): call it first")
    if not any(isinstance(finder, _Finder) for finder in sys.meta_path):
        sys.meta_path.insert(0, _Finder())
    # The first import of a submodule would set the attribute of the package, and `cocotb.log` is a logger too.
    sys.modules.setdefault("cocotb.log", sys.modules["hoverlock.cocotb.log"])
    cocotb.__version__ = VERSIONS[asked]
    cocotb._alias = True
    _core.count_bits_from_left(asked == "1.9")
    types.index_arrays_as_declared(asked != "1.9")
    deprecated.switch(asked != "1.9")
    writes.set_deposits_on_outputs(True)
    hierarchy.lists_hidden = True
    resolve = (os.environ.get("COCOTB_RESOLVE_X") or "ZEROS").upper()
    if resolve not in _UNKNOWN:
        raise ValueError(f"COCOTB_RESOLVE_X={resolve}: {', '.join(_UNKNOWN)}")
    unknown.set_choice(_UNKNOWN[resolve])  # type: ignore[arg-type]
    level = os.environ.get("COCOTB_LOG_LEVEL")
    logger = logging.getLogger("cocotb")
    if level or logger.level == logging.NOTSET:
        # As in cocotb: the log has the messages of packages from level INFO on.
        logger.setLevel((level or "INFO").upper())


class _Callable(ModuleType):
    """The class of this module, which makes it callable."""

    def __call__(self, version: str | None = None) -> None:
        install(version)


sys.modules[__name__].__class__ = _Callable


# ---- as a plug-in of pytest


def pytest_addoption(parser: Any) -> None:
    parser.getgroup("hoverlock").addoption(
        "--cocotb-version", choices=tuple(VERSIONS), default=None, help=VERSION_HELP
    )


def pytest_load_initial_conftests(early_config: Any) -> None:
    install(early_config.known_args_namespace.cocotb_version)


def pytest_configure(config: Any) -> None:
    from .options import design_from
    from .session import set_loading

    set_loading(design_from(config.getoption))


def pytest_collection_finish() -> None:
    from .session import set_loading

    set_loading(None)
