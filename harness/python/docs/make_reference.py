"""Writes the reference of a package, as Markdown, from the docstrings and types of its code.

    python docs/make_reference.py hoverlock.md                                # the bench
    python docs/make_reference.py models.md hoverlock_models                  # other modules, named

`make python-reference` does both. The text is not kept in git.
"""

from __future__ import annotations

import argparse
import ast
import importlib
import inspect
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
PACKAGE = HERE.parent / "hoverlock"
MODULES = [
    "hoverlock", "hoverlock.bus", "hoverlock.fault", "hoverlock.runner", "hoverlock.stub", "hoverlock.log",
    "hoverlock.unknown", "hoverlock.as_cocotb", "hoverlock.deprecated", "hoverlock.cocotb", "hoverlock.cocotb.binary", "hoverlock.cocotb.clock", "hoverlock.cocotb.decorators",
    "hoverlock.cocotb.handle", "hoverlock.cocotb.log", "hoverlock.cocotb.regression", "hoverlock.cocotb.result",
    "hoverlock.cocotb.runner", "hoverlock.cocotb.simulator", "hoverlock.cocotb.triggers", "hoverlock.cocotb.types",
    "hoverlock.cocotb.utils",
]  # fmt: skip
HEAD = """# Reference of {name}

Generated from the code by `make python-reference`.

"""


def rust_classes() -> dict[str, ast.ClassDef | ast.FunctionDef]:
    """Returns the classes and functions that are written in Rust, from their typed stub."""
    tree = ast.parse((PACKAGE / "_core.pyi").read_text())
    return {node.name: node for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}


RUST = rust_classes()


def docs_of(thing: Any) -> str:
    """Returns the docstring as Markdown: examples as code, the sections of numpy's style as lists."""
    lines: list[str] = []
    code = False
    for line in sections_as_lists((inspect.getdoc(thing) or "").splitlines()):
        starts = line.startswith(">>>")
        if starts and not code:
            lines.append("```python")
            code = True
        elif code and not line.strip():
            lines.append("```")
            code = False
        lines.append(line)
    return "\n".join([*lines, "```"] if code else lines)


def sections_as_lists(lines: list[str]) -> list[str]:
    """Turns underlined headings (``Parameters``, ``Returns``, ``Raises``) bold, and each of their entries into a list item."""
    found: list[str] = []
    inside = False
    for at, line in enumerate(lines):
        following = lines[at + 1] if at + 1 < len(lines) else ""
        if following and set(following) == {"-"} and len(following) == len(line):
            found += [f"**{line}**", ""]
            inside = True
        elif line and set(line) == {"-"}:
            continue
        elif line.startswith(">>>") or not inside:
            inside = False
            found.append(line)
        elif not line.strip():
            found.append("")
        elif line.startswith("    "):
            found.append(f"  {line.strip()}")
        else:
            name, colon, kind = line.partition(" : ")
            found.append(f"- `{name}`{' : ' if colon else ''}{kind}")
    return found


class Annotation:
    """A type as it stands in the source, without the quotes of a string."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __repr__(self) -> str:
        return self.text


def signature_of(function: Any) -> str:
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):
        return "(...)"

    def bare(annotation: Any) -> Any:
        text = getattr(annotation, "__forward_arg__", annotation)
        return Annotation(text) if isinstance(text, str) else annotation

    kept = [p for p in signature.parameters.values() if p.name not in ("self", "cls")]
    kept = [p.replace(annotation=bare(p.annotation)) for p in kept]
    bared = signature.replace(parameters=kept, return_annotation=bare(signature.return_annotation))
    return str(bared).replace("~", "")


def stub_signature(node: ast.FunctionDef) -> str:
    arguments = ast.unparse(node.args)
    for first in ("self, ", "self", "cls, ", "cls"):
        if arguments.startswith(first):
            arguments = arguments[len(first) :]
            break
    returns = f" -> {ast.unparse(node.returns)}" if node.returns is not None else ""
    return f"({arguments}){returns}"


def members_of(cls: type) -> list[tuple[str, str, Any]]:
    """Public methods and properties: name, signature (empty for a property), the object with the docstring."""
    found = []
    node = RUST.get(cls.__name__) if cls.__module__ in ("hoverlock", "hoverlock._core", "builtins") else None
    if isinstance(node, ast.ClassDef):
        for item in node.body:
            if isinstance(item, ast.FunctionDef) and not item.name.startswith("_"):
                is_property = any(isinstance(d, ast.Name) and d.id == "property" for d in item.decorator_list)
                found.append((item.name, "" if is_property else stub_signature(item), getattr(cls, item.name)))
            elif isinstance(item, ast.AnnAssign) and isinstance(item.target, ast.Name) and not item.target.id.startswith("_"):
                found.append((item.target.id, "", getattr(cls, item.target.id)))
        return found
    taken = set()
    for level in cls.__mro__:
        if not level.__module__.startswith("hoverlock"):
            continue
        for name, value in vars(level).items():
            if name.startswith("_") or name in taken:
                continue
            taken.add(name)
            if isinstance(value, property):
                found.append((name, "", value))
            elif callable(value) or isinstance(value, (classmethod, staticmethod)):
                found.append((name, signature_of(getattr(cls, name)), getattr(cls, name)))
    return found


def constructor_of(cls: type) -> str:
    node = RUST.get(cls.__name__)
    if isinstance(node, ast.ClassDef) and cls.__module__ in ("hoverlock", "hoverlock._core"):
        made = [i for i in node.body if isinstance(i, ast.FunctionDef) and i.name in ("__new__", "__init__")]
        return stub_signature(made[0]).split(" -> ")[0] if made else ""
    has_signature = not issubclass(cls, (BaseException, dict))
    return signature_of(cls).split(" -> ")[0] if has_signature else ""


def entry(name: str, thing: Any) -> str:
    if inspect.isclass(thing):
        text = f"### `{name}{constructor_of(thing)}`\n\n{docs_of(thing)}\n"
        for member, signature, value in members_of(thing):
            text += f"\n- **`{member}{signature}`** {docs_of(value).split(chr(10) * 2)[0].replace(chr(10), ' ')}"
            rest = docs_of(value).partition("\n\n")[2]
            text += "".join(f"\n  {line}".rstrip() for line in ["", *rest.splitlines()]) if rest else ""
        return text.rstrip() + "\n"
    if callable(thing):
        node = RUST.get(name)
        signature = stub_signature(node) if isinstance(node, ast.FunctionDef) else signature_of(thing)
        return f"### `{name}{signature}`\n\n{docs_of(thing)}\n"
    return f"### `{name}`\n\n`{thing!r}`\n" if not repr(thing).startswith("<") else ""


def build(modules: list[str]) -> str:
    """Returns the text for the public names (`__all__`) of the modules."""
    parts, seen = [HEAD.format(name=modules[0])], set()
    for module_name in modules:
        module = importlib.import_module(module_name)
        parts.append(f"## `{module_name}`\n\n{docs_of(module)}\n")
        again = []
        for name in module.__all__:
            thing = getattr(module, name)
            if inspect.ismodule(thing):
                continue
            key = id(thing)
            if key in seen:
                again.append(f"`{name}`")
                continue
            seen.add(key)
            parts.append(entry(name, thing))
        if again:
            parts.append(f"Also here: {', '.join(again)}.\n")
    return "\n".join(part for part in parts if part)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path, help="the Markdown file to write; its folder is made")
    parser.add_argument("modules", nargs="*", default=MODULES, help="default: the modules of the bench")
    chosen = parser.parse_args()
    chosen.file.parent.mkdir(parents=True, exist_ok=True)
    chosen.file.write_text(build(chosen.modules))


if __name__ == "__main__":
    main()
