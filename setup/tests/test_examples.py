"""The projects in `examples` build and pass as their users run them, outside the workspace."""

import os
import shutil
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ARBITER = ROOT / "examples/arbiter"


def cargo_test(project):
    target = {"CARGO_TARGET_DIR": str(ROOT / "target/examples")}
    return subprocess.run(["cargo", "test", "--quiet", "--locked"], cwd=project, env={**os.environ, **target}, capture_output=True, text=True)


def test_the_arbiter_passes_with_its_own_lock_file():
    done = cargo_test(ARBITER)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "2 passed; 0 failed" in done.stdout


def test_the_bench_of_the_arbiter_finds_a_bug_in_the_verilog(tmp_path):
    project = tmp_path / "arbiter"
    shutil.copytree(ARBITER, project)
    manifest = project / "Cargo.toml"
    manifest.write_text(manifest.read_text().replace("../../harness", str(ROOT / "harness")))
    verilog = project / "verilog/arbiter.v"
    text = verilog.read_text()
    verilog.write_text(text.replace("|first ? first : request", "request"))
    assert verilog.read_text() != text
    done = cargo_test(project)
    assert done.returncode == 101, done.stdout + done.stderr
    assert "grants_follow_the_model" in done.stdout and "0 passed; 2 failed" in done.stdout
