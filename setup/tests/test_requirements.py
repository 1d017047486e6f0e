"""`docs/requirements.toml` is complete in both directions, and `setup/requirements.py` finds what is missing from it."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "setup"))
import requirements

NEEDED = {"statement": "Something holds.", "source": "design", "model": ["model.rs"], "page": "README.md"}


def test_every_requirement_has_evidence_and_all_evidence_a_requirement():
    assert requirements.check() == []


@pytest.fixture
def project(tmp_path):
    """A project with one test, one claim and one module of hardware."""
    files = {
        "README.md": "", "model.rs": "", "tests/one.rs": "#[test]\nfn holds() {}\n", "rtl/src/cell.rs": "#[derive(LogicBlock, Default)]\n",
        "formal/RESULTS.md": "| claim | covers | mutants |\n|---|---|---|\n| `cell` | reached | 2 of 2 |\n", "docs/results.json": "{}",
        "docs/requirements.toml": "",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    subprocess.run(["git", "init", "-q"], cwd=tmp_path, check=True)
    return requirements.Project(tmp_path)


def test_a_complete_requirement_has_no_fault(project):
    complete = NEEDED | {"tests": ["tests/one.rs::holds"], "claims": ["cell"], "hardware": ["rtl/src/cell.rs"]}
    assert requirements.faults("cell", complete, project) == []
    assert requirements.unserved({"cell": complete}, project) == []


@pytest.mark.parametrize("change, fault", [
    ({}, "no test and no claim"),
    ({"claims": ["call"]}, "no claim call"),
    ({"tests": ["tests/two.rs"]}, "tests/two.rs does not exist"),
    ({"tests": ["model.rs"]}, "model.rs has no test"),
    ({"tests": ["tests/one.rs::fails"]}, "tests/one.rs has no test fails"),
    ({"claims": ["cell"], "model": ["other.rs"]}, "other.rs does not exist"),
    ({"claims": ["cell"], "hardware": ["rtl/src/no.rs"]}, "rtl/src/no.rs does not exist"),
    ({"claims": ["cell"], "figures": ["speed"]}, "no figure speed"),
    ({"claims": ["cell"], "source": "hearsay"}, "source is not one of"),
    ({"claims": ["cell"], "statement": ""}, "statement is missing"),
    ({"claims": ["cell"], "test": ["tests/one.rs"]}, "test: no such key"),
])
def test_a_requirement_without_its_evidence_is_found(project, change, fault):
    found = requirements.faults("cell", NEEDED | change, project)
    assert len(found) == 1 and fault in found[0], found


def test_evidence_that_serves_no_requirement_is_found(project):
    found = requirements.unserved({}, project)
    assert [fault.split("; ")[0] for fault in found] == [
        "tests/one.rs: its tests serve no requirement", "claim cell serves no requirement", "rtl/src/cell.rs: its hardware serves no requirement"]


def test_a_page_of_an_older_file_is_found(project):
    (project.root / "docs/requirements.toml").write_text(
        '[cell]\nstatement = "Something | holds."\nsource = "design"\nmodel = ["model.rs"]\nhardware = ["rtl/src/cell.rs"]\n'
        'tests = ["tests/one.rs"]\nclaims = ["cell"]\npage = "README.md"\n')
    assert len(requirements.check(project.root)) == 1
    text = requirements.page(project.requirements(), project)
    (project.root / "docs/requirements.md").write_text(text)
    assert requirements.check(project.root) == []
    assert r"Something \| holds." in text and "`cell` (2)" in text
