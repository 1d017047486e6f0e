"""``cocotb.regression``: tests made from a function and lists of options."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Sequence
from typing import Any

from ..deprecated import advise
from ..errors import SimulationError as SimFailure
from ..testing import Test
from .decorators import coroutine, test

__all__ = ["SimFailure", "TestFactory"]


class TestFactory:
    """A generator of one test for each combination of options.

    >>> factory = TestFactory(run_test)
    >>> factory.add_option("data_in", [random_data, all_ones])
    >>> factory.generate_tests()
    """

    __test__ = False

    def __init__(self, test_function: Any, *args: Any, **kwargs: Any) -> None:
        advise("TestFactory")
        self.function = coroutine(test_function.function if isinstance(test_function, Test) else test_function)
        if args:
            raise TypeError("arguments are given by name: TestFactory(function, name=value)")
        self.fixed = kwargs
        self.options: list[list[dict[str, Any]]] = []

    def add_option(self, name: str | Sequence[str], optionlist: Sequence[Any]) -> None:
        """Adds the values of an option, or of several options that vary together."""
        if isinstance(name, str):
            self.options.append([{name: value} for value in optionlist])
        else:
            self.options.append([dict(zip(name, values, strict=True)) for values in optionlist])

    def generate_tests(self, prefix: str = "", postfix: str = "") -> None:
        """Adds the tests to the module that calls this."""
        module = sys.modules[sys._getframe(1).f_globals["__name__"]]
        for number, choice in enumerate(itertools.product(*self.options), start=1):
            arguments = {**self.fixed, **{key: value for chosen in choice for key, value in chosen.items()}}
            name = f"{prefix}{self.function.__name__}{postfix}_{number:03d}"
            made: Test = test(self.function)
            variant = made.with_arguments(name, arguments)
            variant.module = module.__name__
            setattr(module, name, variant)
