"""Every public name is documented, its examples are valid, and mypy finds no error in the package."""

import ast
import doctest
import importlib
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[1]
MODULES = ["hoverlock_models", "hoverlock_models.bit_true", "hoverlock_models.cosim", "hoverlock_models.smoothers"]


def public():
    for module_name in MODULES:
        module = importlib.import_module(module_name)
        yield module_name, module
        for name in module.__all__:
            thing = getattr(module, name)
            if inspect.isclass(thing) or inspect.isfunction(thing):
                yield f"{module_name}.{name}", thing


def test_every_public_name_is_explained_and_has_a_valid_example():
    for where, thing in public():
        text = inspect.getdoc(thing)
        assert text, where
        examples = doctest.DocTestParser().get_examples(text)
        assert examples or inspect.ismodule(thing), f"{where}: no example"
        for example in examples:
            compile(example.source, where, "exec", flags=ast.PyCF_ALLOW_TOP_LEVEL_AWAIT)


@pytest.mark.parametrize("name", ["coefficients", "look_ahead"])
def test_the_examples_with_a_result_run(name):
    smoothers = importlib.import_module("hoverlock_models.smoothers")
    (test,) = doctest.DocTestFinder(recurse=False).find(getattr(smoothers, name), name, smoothers)
    assert doctest.DocTestRunner().run(test) == (0, 1)


def test_mypy_finds_no_error_in_the_package():
    done = subprocess.run([sys.executable, "-m", "mypy"], cwd=PACKAGE, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
