"""The counts and reasons of `setup/suites.py`, with Makefiles that write results as the harness does."""

import os
import sys
import tarfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import suites

RESULTS = """<testsuites><testsuite><testcase name="a"/><testcase name="b"><skipped/></testcase>
<testcase name="c"><failure message="verilator found errors in the Verilog"/></testcase>
<testcase name="d"><error message="a new error"/></testcase></testsuite></testsuites>"""


def run(folder, recipe):
    (folder / "given.xml").write_text(RESULTS)
    (folder / "Makefile").write_text(f"all:\n\t{recipe}\n")
    return suites.run_makefile(folder, [], dict(os.environ))


def test_failures_and_errors_are_counted_with_their_reasons(tmp_path):
    count = run(tmp_path, "cp given.xml results.xml; false")
    assert dict(count.results) == {"passed": 1, "skipped": 1, "failed": 2}
    assert count.reasons_in_words() == f"Verilator refuses the design once all its internals are accessible (1), {suites.UNEXPLAINED} (1)"
    assert str(count) == "1 passed, 2 failed, 1 skipped"


def test_a_run_without_results_is_one_failure_with_the_reason_of_its_output(tmp_path):
    count = run(tmp_path, "@echo 'hoverlock: TOPLEVEL_LANG=vhdl: Verilator reads Verilog only'; false")
    assert dict(count.results) == {"failed": 1} and count.reasons_in_words() == "VHDL (1)"
    total = suites.Count()
    total.add(count)
    total.add(run(tmp_path, "cp given.xml results.xml; false"))
    assert str(total) == "1 passed, 3 failed, 1 skipped"


def test_a_run_that_never_ends_is_ended_with_its_children(tmp_path):
    (tmp_path / "Makefile").write_text("all:\n\tsleep 600 | yes & echo $$! >child; wait\n")
    started = time.monotonic()
    assert suites.output_of(["make"], tmp_path, dict(os.environ), 2) == ("ended after 2 s", 1)
    assert time.monotonic() - started < 60 and suites.reason_of("ended after 2 s") == "ended by the time limit of this script"
    # A process that was ended may be there until somebody has asked for its status.
    state = Path(f"/proc/{(tmp_path / 'child').read_text().strip()}/stat")
    assert not state.exists() or state.read_text().split()[2] == "Z"


def test_of_a_long_output_the_last_lines_are_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(suites, "KEPT_LINES", 2)
    assert suites.output_of(["seq", "5"], tmp_path, dict(os.environ), 60) == ("4\n5\n", 0)


def test_keys_have_no_characters_that_expressions_use():
    assert suites.key_of("cocotb-2.0.1", "5.048", "make") == "harness.suites.cocotb_2_0_1.v5_048"
    beside = suites.Run("pytest", True, "verilator", "5.048").way
    assert suites.key_of("cocotbext-axi", "5.048", beside) == "harness.suites.cocotbext_axi.v5_048_by_pytest_beside_cocotb"


def test_a_status_without_a_failed_test_is_a_failure(tmp_path):
    passed = RESULTS[: RESULTS.index("<testcase name=\"c\"")] + "</testsuite></testsuites>"
    (tmp_path / "passed.xml").write_text(passed)
    count = run(tmp_path, "cp passed.xml results.xml; false")
    assert str(count) == "1 passed, 1 failed, 1 skipped"


def test_a_makefile_that_ends_with_status_0_has_the_verdict_of_its_authors(tmp_path):
    assert str(run(tmp_path, "cp given.xml results.xml")) == "3 passed, 0 failed, 1 skipped", "it expects its failures"
    (tmp_path / "results.xml").unlink()
    assert str(run(tmp_path, "@echo 'Skipping test, as SIM is verilator'")) == "0 passed, 0 failed, 1 skipped"
    assert str(run(tmp_path, "@echo 'Failed as expected'")) == "1 passed, 0 failed, 0 skipped"


def test_benches_that_never_end_count_as_failed_and_are_not_run(tmp_path, monkeypatch):
    name = "ttihp-verilog-template"
    with tarfile.open(tmp_path / f"{name}.tar.xz", "w:xz") as archive:
        for folder in ("test", "test/endless"):
            (tmp_path / name / folder).mkdir(parents=True)
            (tmp_path / name / folder / "Makefile").write_text("all:\n\t@false\n" if "endless" in folder else "all:\n\t@true\n")
        archive.add(tmp_path / name, arcname=name)
    monkeypatch.setattr(suites, "environment_of", lambda *_: tmp_path)
    monkeypatch.setattr(suites, "ENDLESS", {f"{name}/test/endless": "never ends"})
    monkeypatch.setitem(suites.SUITES, name, suites.Suite(["test/Makefile", "test/*/Makefile"]))
    count = suites.run_suite(name, suites.Run("make", False, "verilator", "5.006"), tmp_path / "work", tmp_path)
    assert dict(count.results) == {"passed": 1, "failed": 1} and count.reasons_in_words() == "never ends (1)"
