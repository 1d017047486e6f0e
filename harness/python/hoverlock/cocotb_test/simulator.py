"""``cocotb_test.simulator``: the function ``run`` and the classes of simulators. All of them run on the harness.

>>> run(verilog_sources=["adder.v"], toplevel="adder", module="test_adder", parameters={"WIDTH": 8})
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..makefile import arguments_of
from ..process import failures_in, run_command

__all__ = ["Icarus", "Simulator", "Verilator", "run"]


class Simulator:
    """A run of a bench, with cocotb-test's arguments. Those of tools that do not exist here are ignored.

    >>> Simulator(toplevel="adder", module="test_adder", verilog_sources=["adder.v"]).run()
    """

    _name = ""
    """The simulator for which arguments are meant; empty if the environment variable ``SIM`` decides."""

    def __init__(
        self,
        toplevel: str | Sequence[str],
        module: str,
        work_dir: str | Path | None = None,
        python_search: Sequence[str | Path] | None = None,
        toplevel_lang: str = "verilog",
        verilog_sources: Sequence[str | Path] | Mapping[str, Sequence[str | Path]] | None = None,
        vhdl_sources: Any = None,
        includes: Sequence[str | Path] | None = None,
        defines: Sequence[str] | Mapping[str, object] | None = None,
        parameters: Mapping[str, object] | None = None,
        compile_args: Sequence[str] | None = None,
        verilog_compile_args: Sequence[str] | None = None,
        sim_args: Sequence[str] | None = None,
        extra_args: Sequence[str] | None = None,
        plus_args: Sequence[str] | None = None,
        testcase: str | Sequence[str] | None = None,
        sim_build: str | Path = "sim_build",
        seed: int | None = None,
        extra_env: Mapping[str, str] | None = None,
        compile_only: bool = False,
        waves: bool | None = None,
        timescale: str | None = None,
        **ignored: Any,
    ) -> None:
        if isinstance(verilog_sources, Mapping):  # by library
            verilog_sources = [path for paths in verilog_sources.values() for path in paths]
        top = toplevel if isinstance(toplevel, str) else toplevel[0]
        name = self._name or os.environ.get("SIM", "icarus")
        defines = [f"{k}={v}" for k, v in defines.items()] if isinstance(defines, Mapping) else defines or []
        flags = [f"-D{define}" for define in defines]
        if name == "verilator":
            flags += [f"-G{key}={value}" for key, value in (parameters or {}).items()]
        else:
            flags += [f"-P{top}.{key}={value}" for key, value in (parameters or {}).items()]
        self.words = ["@simulator", name, "@language", toplevel_lang, "@top", top, "@modules", *str(module).split(",")]
        self.words += ["@sources", *(os.path.abspath(path) for path in verilog_sources or [])]
        self.words += ["@vhdl", *(["given"] if vhdl_sources else [])]
        self.words += ["@includes", *(os.path.abspath(path) for path in includes or [])]
        self.words += ["@compile", *flags, *(compile_args or []), *(extra_args or []), *(verilog_compile_args or [])]
        self.words += ["@run", *(sim_args or []), "@plusargs", *(plus_args or []), "@timescale", timescale or ""]
        self.words += ["@waves", "1" if waves or (waves is None and os.environ.get("WAVES", "0") not in ("", "0")) else "0"]
        chosen = testcase if testcase is not None else os.environ.get("COCOTB_TESTCASE") or os.environ.get("TESTCASE")
        if chosen:
            self.words += ["@tests", chosen if isinstance(chosen, str) else ",".join(chosen)]
        self.words += ["@filter", os.environ.get("COCOTB_TEST_FILTER", "")]
        random_seed = seed if seed is not None else os.environ.get("COCOTB_RANDOM_SEED") or os.environ.get("RANDOM_SEED")
        if random_seed is not None:
            self.words += ["@seed", str(random_seed)]
        self.build_folder = Path(sim_build).absolute()
        self.work_folder = Path(work_dir).absolute() if work_dir is not None and Path(work_dir).is_dir() else self.build_folder
        self.search = [str(path) for path in python_search or []]
        self.environment = dict(extra_env or {})
        self.compile_only = compile_only

    def run(self) -> str:
        """Runs the bench in a process of its own, and returns the file of the results.

        Raises
        ------
        SystemExit
            If a test failed, or the run ended without results.
        """
        __tracebackhide__ = True
        self.build_folder.mkdir(parents=True, exist_ok=True)
        results = os.environ.get("COCOTB_RESULTS_FILE")
        if not results:
            handle, results = tempfile.mkstemp("_results.xml", dir=self.build_folder)
            os.close(handle)
        arguments = arguments_of([*self.words, "@results", results])
        if self.compile_only:
            arguments.insert(0, "--build-only")
        search = os.pathsep.join([*sys.path, *self.search])
        environment = {**self.environment, **os.environ, "PYTHONPATH": search, "COCOTB_RESULTS_FILE": results}
        status = run_command(arguments, folder=self.work_folder, environment=environment)
        if self.compile_only and status == 0:
            return results
        if not os.path.isfile(results) or not os.path.getsize(results):
            raise SystemExit(f"the run ended with status {status} and without results")
        failed = failures_in(results)
        if failed or status:
            raise SystemExit(f"failed: {', '.join(failed)}" if failed else f"the run ended with status {status}")
        return results


class Icarus(Simulator):
    """cocotb-test's class of this name; runs on Verilator, with the arguments for Icarus translated."""

    _name = "icarus"


class Verilator(Simulator):
    """cocotb-test's class of this name."""

    _name = "verilator"


def run(simulator: str | type[Simulator] | None = None, **kwargs: Any) -> str:
    """Runs a bench; the arguments are those of `Simulator`.

    Parameters
    ----------
    simulator : str or type, optional
        The simulator for which the arguments are meant, or its class. The environment variable ``SIM`` overrides a name.

    >>> run("verilator", verilog_sources=["adder.v"], toplevel="adder", module="test_adder")
    """
    __tracebackhide__ = True
    if os.environ.get("COCOTB_TEST_SIM_BUILD"):
        kwargs["sim_build"] = os.environ["COCOTB_TEST_SIM_BUILD"]
    if simulator is None or isinstance(simulator, str):
        name = os.environ.get("SIM") or simulator or "icarus"
        simulator = Verilator if name == "verilator" else Icarus
    return simulator(**kwargs).run()
