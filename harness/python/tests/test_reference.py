"""The reference can be built; every public name is documented, and its examples are valid."""

import ast
import doctest
import importlib
import importlib.util
import inspect
import re
import subprocess
import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parents[1] / "docs"


def load():
    spec = importlib.util.spec_from_file_location("make_reference", DOCS / "make_reference.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules["make_reference"] = module
    spec.loader.exec_module(module)
    return module


make_reference = load()


def public():
    """Every public name: module, name, what it is."""
    for module_name in make_reference.MODULES:
        module = importlib.import_module(module_name)
        yield module_name, "", module
        for name in module.__all__:
            thing = getattr(module, name)
            if not inspect.ismodule(thing):
                yield module_name, name, thing


def own_docs(thing):
    """Its docstring, unless it is only inherited from what Python gives to all."""
    text = inspect.getdoc(thing) or ""
    return "" if inspect.isclass(thing) and text in {inspect.getdoc(base) for base in (object, Exception, int, list)} else text


def test_the_reference_can_be_built(tmp_path):
    made = tmp_path / "new" / "reference.md"
    subprocess.run([sys.executable, DOCS / "make_reference.py", made], check=True)
    text = made.read_text()
    for module, name, thing in public():
        if not name:
            assert f"\n## `{module}`\n" in text
        elif inspect.isclass(thing) or inspect.isfunction(thing):
            assert f"### `{name}" in text or f"`{name}`" in text, f"{module}.{name} is missing"


def test_every_module_of_the_package_is_in_it():
    inner = {
        "_core", "__main__", "pytest_plugin", "clean_up", "clock", "design", "errors", "hierarchy", "options", "outputs", "queue",
        "session", "tasks", "testing", "bus._path", "bus.memory_mapped", "bus.stream", "transfer", "triggers", "utils",
        "writes", "cocotb.queue", "cocotb.logging", "cocotb.simtime", "cocotb.task", "cocotb._bridge",
        "flags", "makefile", "process", "supervisor", "cocotb.config", "cocotb._typing", "cocotb._base_triggers", "cocotb._outcomes",
        "cocotb.ANSI", "cocotb.debug", "cocotb.outcomes", "cocotb.types.array", "cocotb.types.logic", "cocotb.types.logic_array",
        "cocotb.types.range", "cocotb_test", "cocotb_test.simulator",
    }  # fmt: skip
    found = {
        ".".join(path.relative_to(make_reference.PACKAGE).with_suffix("").parts).removesuffix(".__init__")
        for path in make_reference.PACKAGE.rglob("*.py")
    }
    named = {name.removeprefix("hoverlock.") for name in make_reference.MODULES}
    assert {f for f in found if not f.startswith("cocotb_tools") and f != "__init__"} - inner == named - {"hoverlock"}


def test_every_public_name_is_explained():
    silent = []
    for module, name, thing in public():
        if not (inspect.ismodule(thing) or inspect.isclass(thing) or callable(thing)):
            continue
        if not own_docs(thing):
            silent.append(f"{module}.{name}")
        if inspect.isclass(thing) and thing.__module__.startswith("hoverlock"):
            silent += [f"{module}.{name}.{m}" for m, _, value in make_reference.members_of(thing) if not inspect.getdoc(value)]
    assert not silent, f"no docstring: {sorted(set(silent))}"


def test_every_public_name_has_an_example():
    """But for errors, which explain themselves, and for names of cocotb that only stand for another."""
    without = []
    for module, name, thing in public():
        of_cocotb = module.startswith("hoverlock.cocotb")
        is_error = inspect.isclass(thing) and issubclass(thing, BaseException)
        if name and not of_cocotb and not is_error and callable(thing) and ">>>" not in own_docs(thing):
            without.append(f"{module}.{name}")
    assert not without, without


def examples():
    seen = set()
    for module, name, thing in public():
        parts = [(name, thing)]
        if inspect.isclass(thing):
            parts += [(f"{name}.{m}", value) for m, _, value in make_reference.members_of(thing)]
        for where, part in parts:
            text = inspect.getdoc(part) or ""
            if ">>>" in text and text not in seen:
                seen.add(text)
                yield f"{module}.{where}", text


def test_the_examples_are_python():
    count = 0
    for where, text in examples():
        for example in doctest.DocTestParser().get_examples(text):
            try:
                compile(example.source, where, "exec", flags=ast.PyCF_ALLOW_TOP_LEVEL_AWAIT)
            except SyntaxError as error:
                pytest.fail(f"{where}: {error}: {example.source}")
            count += 1
    assert count > 80


# Those that need no design run as they stand.
PURE = [
    "hoverlock.cocotb.types", "hoverlock.cocotb.binary", "hoverlock.runner", "hoverlock.cocotb.utils",
]  # fmt: skip


@pytest.mark.parametrize("name", PURE)
def test_the_examples_run(name):
    module = importlib.import_module(name)
    ran = 0
    for test in doctest.DocTestFinder(exclude_empty=True).find(module, name):
        # With a result, and with nothing named that only a bench has.
        free = re.compile(r"\b(frame|design|dut|await|test_counter\.py\", Design|run\()")
        if not any(example.want for example in test.examples) or any(free.search(e.source) for e in test.examples):
            continue
        results = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(test)
        assert results.failed == 0, test.name
        ran += results.attempted
    assert ran > 0
