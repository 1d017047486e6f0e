"""``python -m cocotb_tools.combine_results``: the results files of a folder as one, and the failures in them. The exit status is
1 if there are any."""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path
from xml.etree import ElementTree

__all__ = ["main"]


def main() -> int:
    """Writes one file with the suites of all results files below the folders, and prints a line for each failed test."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("directories", nargs="*", type=Path, default=[Path()])
    parser.add_argument("-i", "--input-filename", default=r"results.*\.xml", help="a regular expression")
    parser.add_argument("-o", "--output-file", default="combined_results.xml")
    parser.add_argument("--output-testsuites-name", default="results")
    parser.add_argument("--verbose", action="store_true")
    parser.add_argument("--repo-root", type=Path, help="has no effect here")
    chosen = parser.parse_args()
    combined = ElementTree.Element("testsuites", name=chosen.output_testsuites_name)
    for path in sorted(path for folder in chosen.directories for path in folder.rglob("*")):
        if path.is_file() and re.match(chosen.input_filename, path.name):
            combined.extend(ElementTree.parse(path).iter("testsuite"))
            if chosen.verbose:
                print(f"Reading file {path}.")
    failed = 0
    for suite in combined:
        for case in suite.iter("testcase"):
            if case.find("failure") is not None or case.find("error") is not None:
                failed += 1
                where = f"classname: '{case.get('classname')}' testcase: '{case.get('name')}'"
                print(f"Failure in testsuite: '{suite.get('name')}' {where} with parameters '{suite.get('package')}'")
    print(f"Ran a total of {len(combined)} TestSuites and {len(list(combined.iter('testcase')))} TestCases")
    ElementTree.ElementTree(combined).write(chosen.output_file, encoding="UTF-8")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
