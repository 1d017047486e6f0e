"""Typed stubs of a design: an editor completes ``dut.video_data``, and mypy reports ``dut.vidoe_data``.

    python -m hoverlock stub counter.v --top counter -o counter_dut.pyi

The stub is a file beside the bench, which imports the type for type checkers only:

    if TYPE_CHECKING:
        from counter_dut import Counter

    @hoverlock.test()
    async def counts(dut: "Counter") -> None: ...
"""

from __future__ import annotations

import argparse
import keyword
import os
import sys
from pathlib import Path

from ._core import ArrayHandle, Handle
from .design import Design
from .errors import HoverlockError
from .hierarchy import Constant, Hierarchy
from .session import Session

__all__ = ["main", "stub_of"]


def stub_of(design: Design) -> str:
    """Returns the text of a stub: a class for the top module, and one for each instance with accessible signals.

    Raises
    ------
    BuildError
        If the design does not build.

    >>> Path("counter_dut.pyi").write_text(stub_of(design))
    """
    with Session(design, name="stub") as session:
        classes: list[str] = []
        _write(session.dut, design.top, classes)
    head = f'"""The signals of `{design.top}`; made by `python -m hoverlock stub`."""\n\n'
    return head + "from hoverlock import ArrayHandle, Constant, Handle, TypedHierarchy\n\n" + "\n".join(classes)


def _write(node: Hierarchy, path: str, classes: list[str]) -> str:
    """Appends the class of a level, after those of the levels below it; returns its name."""
    name = "".join(part[:1].upper() + part[1:] for part in _words(path))
    lines: list[str] = []
    indexed: set[str] = set()
    for child_name in node._children:
        child = node._children[child_name]
        if isinstance(child, Hierarchy):
            kind = _write(child, f"{path}.{child_name}", classes)
        else:
            kind = type(child).__name__
        if not child_name.isidentifier() or keyword.iskeyword(child_name):
            if isinstance(child, Hierarchy):
                indexed.add(kind)
            continue
        lines.append(f"    {child_name}: {kind}{_comment(child)}\n")
    if indexed:
        lines.append(f"    def __getitem__(self, key: int | str) -> {' | '.join(sorted(indexed))}: ...\n")
    classes.append(f"class {name}(TypedHierarchy):\n" + ("".join(lines) or "    ...\n"))
    return name


def _words(path: str) -> list[str]:
    return [word for word in "".join(c if c.isalnum() else " " for c in path).split() if word]


def _comment(child: object) -> str:
    if isinstance(child, Handle):
        sign = ", signed" if child.is_signed else ""
        return f"  # {child.direction}, {len(child)} bit{'s' if len(child) > 1 else ''}{sign}"
    if isinstance(child, ArrayHandle):
        return f"  # {child.direction}, {len(child)} elements"
    if isinstance(child, Constant):
        return f"  # {child.value!r}"
    return ""


def main(arguments: list[str]) -> int:
    """Writes a typed stub of a design. Exit status 2 on wrong usage, or if the design does not build.

    >>> main(["counter.v", "--top", "counter", "-o", "counter_dut.pyi"])
    """
    from .options import design_from

    parser = argparse.ArgumentParser(prog="python -m hoverlock stub", description=(main.__doc__ or "").partition("\n")[0])
    parser.add_argument("sources", nargs="+", metavar="FILE", help="Verilog sources")
    parser.add_argument("--top", required=True, metavar="MODULE", help="top module")
    parser.add_argument("--parameter", action="append", default=[], metavar="NAME=VALUE", help="parameter (may be repeated)")
    parser.add_argument("--internal", action="append", default=[], metavar="PATTERN",
                        help="internal signals to make accessible, such as 'u_core.*' (may be repeated)")
    parser.add_argument("-o", "--output", metavar="FILE", help="the file to write (default: standard output)")
    chosen = parser.parse_args(arguments)
    try:
        given = {"source": chosen.sources, "top": chosen.top, "parameter": chosen.parameter, "internal": chosen.internal}
        design = design_from(lambda name: given.get(name.removeprefix("hoverlock_"), []))
        assert design is not None
        text = stub_of(design)
        if chosen.output is None:
            print(text, end="")
            return 0
        path = Path(chosen.output)
        aside = path.with_name(f".{path.name}.{os.getpid()}")
        aside.write_text(text)
        aside.replace(path)
    except (HoverlockError, OSError) as error:
        print(f"hoverlock: {error}", file=sys.stderr)
        return 2
    return 0
