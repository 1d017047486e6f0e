"""The command behind ``hoverlock.mk``: runs the benches that the variables of a Makefile written for cocotb describe.

    python -m hoverlock make @top adder @modules test_adder @sources adder.v @compile -GWIDTH=8

The words after ``@name`` are those of the variable, after the shell has expanded globs and removed quotes.
"""

from __future__ import annotations

import contextlib
import glob
import os
import re
import shlex
from collections.abc import Iterable, Sequence

from .design import Design
from .errors import BuildError, HoverlockError
from .flags import harness_flags
from .log import log

__all__ = ["SECTIONS", "arguments_of", "config", "icarus_flags", "verilator_flags", "without_unknown_parameters"]

SECTIONS = (
    "simulator", "language", "top", "modules", "sources", "vhdl", "includes", "compile", "run", "plusargs", "timescale",
    "waves", "seed", "tests", "filter", "results", "options",
)  # fmt: skip
"""The variables, in any order."""

_TIMESCALE = re.compile(r"\d+\s*(s|ms|us|ns|ps|fs)/\d+\s*(s|ms|us|ns|ps|fs)")


def config(arguments: Sequence[str] | None = None) -> int:
    """The command ``cocotb-config``: prints the folder of ``Makefile.sim``, Python's path, or the version that the alias
    follows. Options that name libraries for other simulators are refused with status 2."""
    import sys

    from .as_cocotb import VERSIONS

    given = list(sys.argv[1:] if arguments is None else arguments)
    folder = os.path.dirname(os.path.abspath(__file__))
    answers = {
        "--makefiles": os.path.join(folder, "makefiles"),
        "--share": folder,
        "--prefix": os.path.dirname(folder),
        "--python-bin": sys.executable,
        "--version": VERSIONS[os.environ.get("HOVERLOCK_COCOTB") or "2.1"],
        "-v": VERSIONS["2.1"],
    }
    if len(given) == 1 and given[0] in answers:
        print(answers[given[0]])
        return 0
    print(f"cocotb-config of hoverlock answers {', '.join(answers)}; there are no VPI libraries here", file=sys.stderr)
    return 2


def arguments_of(words: Iterable[str]) -> list[str]:
    """Returns the arguments of ``python -m hoverlock`` for the words of a Makefile's variables.

    Raises
    ------
    HoverlockError
        If the top or the modules are missing, or if the Makefile asks for VHDL.

    >>> arguments_of(["@top", "adder", "@modules", "test_adder", "@sources", "adder.v"])
    """
    given: dict[str, list[str]] = {name: [] for name in SECTIONS}
    section = ""
    for word in words:
        if word.startswith("@") and word[1:] in given:
            section = word[1:]
        elif section:
            given[section] += [word] if word else []  # quotes around nothing, as in EXTRA_ARGS += ""
        else:
            raise HoverlockError(f"make {word}: one of {', '.join('@' + name for name in SECTIONS)} comes first")
    if given["language"][:1] == ["vhdl"]:
        raise HoverlockError("TOPLEVEL_LANG=vhdl: Verilator reads Verilog only")
    if given["vhdl"]:
        raise HoverlockError("VHDL_SOURCES: Verilator reads Verilog only")
    if not given["top"]:
        raise HoverlockError("TOPLEVEL is not set")
    modules = [name.strip() for name in " ".join(given["modules"]).replace(" ", ",").split(",")]
    modules = [name for name in modules if name]
    if not modules:
        raise HoverlockError("MODULE is not set")
    results = (given["results"] or ["results.xml"])[0]
    arguments = ["--as-cocotb", "--junit", results, "--hoverlock-top", given["top"][0].rpartition(".")[2]]
    sources = [path for source in given["sources"] for path in sorted(glob.glob(source)) or [source]]
    for source in dict.fromkeys(sources):
        arguments += ["--hoverlock-source", source]
    simulator = (given["simulator"] or ["verilator"])[0].lower()
    flags = (verilator_flags if simulator == "verilator" else icarus_flags)(given["compile"])
    waves = None
    with contextlib.suppress(BuildError):  # the build reports it
        waves = harness_flags(flags)[1]
    if simulator != "verilator":
        arguments.append("--ignore-unknown-parameters")
    timescale = "".join(given["timescale"])
    if _TIMESCALE.fullmatch(timescale):
        flags += ["--timescale", timescale]
    flags += [f"-I{folder}" for folder in given["includes"]]
    arguments += [f"--hoverlock-flag={flag}" for flag in flags]
    arguments += [f"--hoverlock-plusarg={word}" for word in [*given["plusargs"], *given["run"]] if word.startswith("+")]
    if given["waves"] not in ([], ["0"]) or waves:
        arguments += ["--hoverlock-waves", waves or "vcd"]
    if given["seed"]:
        arguments += ["--hoverlock-seed", given["seed"][0]]
    if given["tests"]:
        arguments += ["--test", ",".join(" ".join(given["tests"]).replace(",", " ").split())]
    if given["filter"] and given["filter"][0]:
        arguments += ["--filter", given["filter"][0]]
    return [*arguments, *given["options"], *modules]


def verilator_flags(words: Iterable[str]) -> list[str]:
    """Returns the flags of Verilator among a Makefile's, with absolute paths, because Verilator runs in another folder; and
    with the contents of files of arguments (``-f``)."""
    flags: list[str] = []
    rest = iter(words)
    for word in rest:
        if word in ("-f", "-F", "-file"):
            flags += verilator_flags(_words_of_file(next(rest, ""), relative=word == "-F"))
        elif word in ("-v", "-y", "-I", "-l"):
            flags += [word + os.path.abspath(next(rest, ""))] if word == "-I" else [word, os.path.abspath(next(rest, ""))]
        elif word in ("-D", "-G"):
            flags.append(word + next(rest, ""))
        elif not word.startswith(("-", "+")) and os.path.isfile(word):
            flags.append(os.path.abspath(word))
        else:
            flags.append(word)
    return flags


_UNKNOWN = re.compile(r"Parameters from the command line were not found in the design: ([\w, ]+)")


def without_unknown_parameters(design: Design) -> Design:
    """Returns the design without the flags ``-GNAME=VALUE`` for parameters that its top does not have, as Icarus ignores them.
    Any other error of the build is left to those who build it."""
    try:
        design.compile()
    except BuildError as error:
        found = _UNKNOWN.search(str(error))
        if found is None:
            return design
        names = set(found[1].replace(",", " ").split())
        log.warning("no parameters of %s, and left out: %s", design.top, ", ".join(sorted(names)))
        kept = [flag for flag in design.flags if not (flag.startswith("-G") and flag[2:].partition("=")[0] in names)]
        return design.changed(flags=kept)
    return design


def _words_of_file(path: str, *, relative: bool) -> list[str]:
    """Returns the words of a file of arguments; with ``relative``, its paths begin at the file's folder."""
    try:
        with open(path) as file:
            text = file.read()
    except OSError as error:
        raise HoverlockError(f"-f {path}: {error.strerror}") from error
    text = re.sub(r"/\*.*?\*/|(?://|#)[^\n]*", " ", text, flags=re.DOTALL)
    words = [os.path.expandvars(word) for word in shlex.split(text)]
    folder = os.path.dirname(path) if relative else ""
    inside = [os.path.join(folder, word) for word in words]
    return [there if folder and os.path.exists(there) else word for word, there in zip(words, inside)]


def icarus_flags(words: Iterable[str]) -> list[str]:
    """Returns Verilator's flags for those of Icarus: macros, parameters and folders have equivalents, the others are of no
    use here."""
    flags: list[str] = []
    rest = iter(words)
    for word in rest:
        if word in ("-D", "-I", "-P", "-y", "-s", "-f", "-c"):
            value = next(rest, "")
            if word in "-f -c":
                flags += icarus_flags(_words_of_file(value, relative=False))
                continue
            word += value
        if word.startswith("-P"):
            name, equals, value = word[2:].partition("=")
            flags.append(f"-G{name.rpartition('.')[2]}{equals}{value}")
        elif word.startswith("-y"):
            flags += ["-y", os.path.abspath(word[2:])]
        elif word.startswith(("-D", "-I", "+incdir+", "+define+")):
            flags.append(word)
        elif not word.startswith(("-", "+")) and os.path.isfile(word):
            flags.append(os.path.abspath(word))
    return flags
