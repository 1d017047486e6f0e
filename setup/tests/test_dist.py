"""`setup/dist.sh` with a command and a wheel that stand for the built ones."""

import subprocess
import tarfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
COMMAND = """#!/bin/sh
case $1 in man) echo page >"$2/hoverlock.1" ;; completions) echo complete ;; *) exit 2 ;; esac
"""


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    folder = tmp_path_factory.mktemp("dist")
    (folder / "hoverlock").write_text(COMMAND)
    (folder / "hoverlock").chmod(0o755)
    (folder / "wheels").mkdir()
    (folder / "wheels/hoverlock-0.1.0-cp311.whl").write_text("wheel")
    done = subprocess.run([ROOT / "setup/dist.sh", folder / "hoverlock", folder / "wheels", folder / "out"], stdout=subprocess.PIPE,
                          check=True, text=True)
    (path,) = (folder / "out").iterdir()
    assert done.stdout.strip() == str(path)
    with tarfile.open(path) as tar:
        yield tar


def test_the_archive_has_command_wheels_verilog_component_and_documents(archive):
    names = {name.partition("/")[2] for name in archive.getnames()}
    emitted = subprocess.run(["git", "ls-files", "rtl/verilog", "rtl/registers", "rtl/quartus", "designs"], cwd=ROOT,
                             stdout=subprocess.PIPE, check=True, text=True).stdout.split()
    assert names >= {"bin/hoverlock", "wheels/hoverlock-0.1.0-cp311.whl", "share/man/man1/hoverlock.1",
                     "share/bash-completion/completions/hoverlock", "README.md", "docs/results.json", "LICENSE-MIT", "INSTALL.md",
                     *emitted}
    assert archive.getmember(f"{archive.getnames()[0]}/bin/hoverlock").mode & 0o111


def test_links_between_the_documents_of_the_archive_are_kept(archive):
    names = {name.partition("/")[2] for name in archive.getnames()}
    documents = subprocess.run(["git", "ls-files", "*.md", ":!docs/tables"], cwd=ROOT, stdout=subprocess.PIPE, check=True,
                               text=True).stdout.split()
    assert set(documents) <= names
