"""The keys under which benches and campaigns store their numbers are those of `docs/results.json`."""

import importlib.util
import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "setup"))
import measure
import results


def module(path: str):
    spec = importlib.util.spec_from_file_location(Path(path).stem, ROOT / path)
    loaded = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded


def assert_complete(values: dict, *entries: str, without: tuple = ()):
    """The keys are all values of the entries, except for `without`, which something else measures."""
    known = {f"{entry}.{name}" for entry in entries for name in results.Results().entries[entry]["values"]}
    assert set(values) == known - set(without)


def test_the_bench_against_cocotb():
    run = module("harness/benches/against_cocotb/run.py")
    speed = {label: {name: [1.0, 3.0, 2.0] for name in [*run.NAMES, "frames"]}
             for label in (run.OURS, run.FIRST, run.SECOND, run.OURS_ON_NEWER, run.THIRD)}
    others = {name: [2.0] for name in ("loop", "loop on the top", "arrays", "arrays, 25 % back-pressure", "arrays on the top",
                                       "arrays on the top, 25 % back-pressure")}
    started = {name: (1.0, 2.0) for name in ("the interpreter alone", "the interpreter and `import hoverlock`", "a cached test",
                                             "after an edit of the Verilog")}
    values = run.entries(speed, others, started)
    assert values["harness.python.per_cycle"] == 2
    assert run.installed_from('{"archive_info": {}, "url": "file:///a/hoverlock-0.1.0-cp311-cp311-linux_x86_64.whl"}') == "the wheel of `make wheel`"
    assert run.installed_from('{"dir_info": {}, "url": "file:///a"}') == run.installed_from(None) == "a build for development"
    assert_complete(values, "harness.python", "harness.python_newer", "harness.start",
                    without=("harness.start.import_without_bytecode", "harness.start.cached_test_without_bytecode",
                             "harness.start.cached_model"))


def test_the_bench_of_accuracy():
    report = module("reference/benches/accuracy_report.py")
    conditions = ["nominal", "gain", "noise", "blur", "mist .5", "mist .25", "combined", "altitude", "yaw", "drift", "relief", "hover",
                  "narrow", "narrow noisy"]
    number = dict.fromkeys(("first", "last", "localisation", "centre", "nees"), "0.5")
    rows = [number | {"condition": condition, "method": method, "refined": refined, "pose": pose} for condition in conditions
            for method in report.METHODS if method not in report.FLOWN for refined, pose in (("0", "0.5"), ("1", "0.25"))]
    # The flight program gives no matches.
    flown = {"refined": "1", "first": "NaN", "last": "NaN", "localisation": "NaN", "centre": "", "pose": "0.1", "nees": "2"}
    rows += [flown | {"method": method, "condition": condition} for method in report.FLOWN for condition in conditions]
    values = report.values(rows)
    methods = values["accuracy.methods"]
    assert (methods["ORB.wide"], methods["ORB.refined_wide"], methods["flights"]) == (50, 25, len(conditions))
    assert (methods["Flight_program.wide"], values["accuracy.covariance"]["all.flight_program_nees"]) == (10, 2)
    assert_complete({f"{entry}.{name}": value for entry, named in values.items() for name, value in named.items()}, *values)


@pytest.mark.parametrize("bench", ["small", "top"])
def test_the_bench_without_python(bench):
    source = (ROOT / f"harness/benches/throughput/{bench}.rs").read_text()
    keys = set(re.findall(r'(?:key: |(?:direct|way)\(\s*"[^"]+",\s*)"(\w+)"', source))
    known = {name.partition(".")[2] for name in results.Results().entries["harness.rust"]["values"] if name.startswith(f"{bench}.")}
    assert keys == known


def test_simulation_and_estimates():
    fields = ("pixels", "cycles", "cycles_per_pixel", "samples", "features", "mismatches", "latency_lines", "feature_latency_lines")
    values = measure.of_simulation(dict.fromkeys(fields, 1) | {"cycles_per_second": 754_321.0})
    assert values.pop("sim.speed") == 750_000
    assert_complete(values, "sim.aero1")
    fields = ("alm", "m10k", "dsp", "mul18", "mlab", "registers", "logic_levels", "cell_delay_ps", "target_mhz")
    out = dict.fromkeys(fields, 1) | {"devices": [{"used_percent": [1.0, 2.0, 3.0]}], "modules": [{"name": "lerp", "cell_delay_ps": 5}]}
    for design in ("kt27", "hd1080", "small", "three_scales"):
        assert_complete(measure.of_estimate(design, out), f"rtl.estimate.{design}")
