"""Verilator's flags in a form that this harness can build with.

>>> flags, waves, coverage = harness_flags(["--trace", "-GWIDTH=8"])
>>> flags, waves
(('-GWIDTH=8',), 'vcd')
"""

from __future__ import annotations

from collections.abc import Iterable

from .errors import BuildError

__all__ = ["harness_flags"]

_WAVES = {"--trace": "vcd", "--trace-vcd": "vcd", "--trace-fst": "fst"}
_COVERAGE = ("--coverage", "--coverage-line", "--coverage-toggle", "--coverage-user")
# What the harness decides itself, with the number of words that follow. A model runs in one thread, without timing, and its
# signals are accessible by name; the results do not depend on these.
_LEFT_OUT = {
    "--timing": 0, "--no-timing": 0, "--vpi": 0, "--public-flat-rw": 0, "--public-flat": 0, "--public": 0, "--cc": 0, "--build": 0,
    "--exe": 0, "--main": 0, "--main-top-name": 1, "--threads": 1, "--trace-threads": 1, "--threads-dpi": 1, "--build-jobs": 1,
    "--verilate-jobs": 1, "-j": 1, "-o": 1, "--Mdir": 1, "--prefix": 1, "--top-module": 1, "--top": 1, "-CFLAGS": 1, "-MAKEFLAGS": 1,
    "--quiet": 0, "--quiet-exit": 0, "--stats": 0, "--MMD": 0, "-MMD": 0, "--debug": 0, "--gdb": 0, "--gdbbt": 0,
}  # fmt: skip
_REFUSED = {
    "--sc": "models are C++, not SystemC",
    "--trace-saif": "waves are VCD or FST",
    "--hierarchical": "the model is one library",
    "--savable": "models are not saved",
    "--protect-lib": "the model is one library",
    "--lib-create": "the model is one library",
    "-LDFLAGS": "no libraries are linked to a model",
    "--xml-only": "the flag makes no model",
    "--json-only": "the flag makes no model",
    "--lint-only": "the flag makes no model",
}


def harness_flags(flags: Iterable[str]) -> tuple[tuple[str, ...], str | None, bool]:
    """Returns the flags for a build, the format of the waves among them, and whether coverage is among them. Flags that
    choose how Verilator is run, but not what the design does, are left out.

    Raises
    ------
    BuildError
        If a flag cannot be heeded.
    """
    kept: list[str] = []
    waves: str | None = None
    coverage = False
    words = iter(flags)
    for word in words:
        # Verilator reads one dash and two alike.
        double = f"-{word}" if word.startswith("-") and not word.startswith("--") else word
        name = word if word in _LEFT_OUT or word in _REFUSED else double.partition("=")[0]
        if name in _WAVES:
            waves = "fst" if "fst" in (waves, _WAVES[name]) else "vcd"
        elif name in _COVERAGE:
            coverage = True
        elif name in _REFUSED:
            raise BuildError(f"the flag {word} of Verilator: {_REFUSED[name]}")
        elif name in _LEFT_OUT:
            if "=" not in word:
                for _ in range(_LEFT_OUT[name]):
                    next(words, None)
        elif not (name.startswith("-j") and name[2:].isdigit()):
            kept.append(word)
    return tuple(kept), waves, coverage
