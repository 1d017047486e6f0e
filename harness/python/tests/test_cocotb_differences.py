"""The page "Coming from cocotb" says what is so: each row of its table has a bench that shows it."""

import importlib.util
import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parents[1] / "docs"


def load():
    spec = importlib.util.spec_from_file_location("differences", DOCS / "differences.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules["differences"] = module
    spec.loader.exec_module(module)
    return module


differences = load()


def test_the_page_is_up_to_date():
    assert differences.PAGE.read_text() == differences.page(), "run python docs/differences.py"
    assert differences.BEGIN in differences.PAGE.read_text() and len(differences.ROWS) > 25


@pytest.mark.parametrize("row", differences.ROWS, ids=lambda row: row.what.replace("`", "")[:30])
def test_it_differs_as_the_page_says(row):
    row.check()
