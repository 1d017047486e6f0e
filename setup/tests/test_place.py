"""Figures are read from the reports of Yosys and nextpnr; what fails is one line, and is not recorded.

`place_pair.json` is the output of both tools for a small module, `pair`, of two adders with registers behind one another, without the
fields that are not read.
"""

import copy
import json
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "setup"))
import place

PAIR = json.loads((Path(__file__).parent / "place_pair.json").read_text())


@pytest.fixture
def pair() -> dict:
    return copy.deepcopy(PAIR)


def names_of(pair: dict) -> place.Names:
    return place.Names(pair["netlist"], pair["modules"])


def test_the_longest_path_is_that_between_registers(pair):
    found = place.placed(pair["report"], names_of(pair))
    assert (found.start, found.end) == ("first.y", "second.y")
    assert found.mhz == pytest.approx(566.25, abs=0.01)
    # The path from the pin takes 3.7 ns, and is none.
    assert (found.logic_ns, found.routing_ns) == (pytest.approx(0.761), pytest.approx(1.005))
    assert 1e3 / found.mhz == pytest.approx(found.logic_ns + found.routing_ns, abs=0.01)


def test_registers_are_named_by_the_instance_that_drives_them(pair):
    names = names_of(pair)
    of = {name: net["bits"][0] for name, net in pair["netlist"]["netnames"].items()}
    # The netlist has the name `advance` of an input of the part, and `x` of one of the first adder.
    assert names.register(of["part.advance"]) == "port advance"
    assert names.register(of["part.first.x"]) == "port x"
    assert names.register(of["part.second.y"]) == "second.y"
    assert names.register(of["place_out"]) == "port y"
    assert names.register(of["place_chain"]) == place.HARNESS
    # Between the adders a net has names in three modules, and the first adder drives it.
    assert names.driver(["part"], "middle", 1) == (["part", "first"], "y", 1)
    assert names.driver(["part", "second"], "x", 1) == (["part", "first"], "y", 1)
    assert names.driver(["part", "second"], "x_LUT4_Z", 1) is None
    assert names.endpoint("part.second.y_TRELLIS_FF_Q", "CE") == "second.y, enable"
    assert names.endpoint("part.lines.memory.0.3", "DOA4") == "lines.memory.0.3"


def test_the_utilisation_is_that_of_the_part_alone(pair):
    # Each adder has two registers, and one gate in front of each. Around them are 12 registers.
    assert place.utilisation(pair["netlist"], names_of(pair)) == {"lut4": 4, "ff": 4, "ebr": 0, "dsp": 0}
    pair["netlist"]["cells"] |= {
        "part.memory.0.0": {"type": "DP16KD", "connections": {}},
        "part.product": {"type": "MULT18X18D", "connections": {}},
        "part.sum": {"type": "CCU2C", "connections": {}},
        "part.taps.0.0": {"type": "TRELLIS_DPR16X4", "connections": {}},
    }
    assert place.utilisation(pair["netlist"], names_of(pair)) == {"lut4": 4 + 2 + 6, "ff": 4, "ebr": 1, "dsp": 1}


def test_a_report_with_another_number_of_clocks_is_refused(pair):
    pair["report"]["fmax"]["other"] = {"achieved": 1.0, "constraint": 100}
    with pytest.raises(place.Failure, match="2 clocks in the report"):
        place.placed(pair["report"], names_of(pair))
    pair = copy.deepcopy(PAIR)
    pair["report"]["critical_paths"] = pair["report"]["critical_paths"][1:]
    with pytest.raises(place.Failure, match="0 longest paths"):
        place.placed(pair["report"], names_of(pair))


def test_registers_are_at_all_ports():
    verilog = place.harness("pair", PAIR["modules"]["pair"]["ports"])
    assert "pair part (\n  .clock(clock),\n  .advance(place_in[0:0]),\n  .x(place_in[2:1]),\n  .y(place_y[1:0])\n);" in verilog
    with pytest.raises(place.Failure, match="no port `clock`"):
        place.harness("gate", {"y": {"direction": "output", "bits": [1]}})


def test_the_first_error_of_a_tool_is_its_reason():
    memory = "Warning: a wire\nERROR: no valid mapping found for memory place_top.part.taps.memory\nERROR: more\n"
    assert place.reason_in(memory, 1) == "no valid mapping found for memory place_top.part.taps.memory"
    assert place.reason_in("ERROR: Unable to place cell 'm', no BELs remaining to implement cell type 'DP16KD'\n2 warnings, 1 error\n", 255) == (
        "Unable to place cell 'm', no BELs remaining to implement cell type 'DP16KD'"
    )
    assert place.reason_in("", 134) == "ended with status 134"


def test_what_fails_is_one_line_and_has_no_figures(monkeypatch, tmp_path, capsys):
    figures = {"mhz": 100.0, "mhz_lowest": 99.0, "mhz_highest": 101.0, "from": "a", "to": "b", "logic_ns": 5.0, "routing_ns": 5.0, "lut4": 1,
               "ff": 1, "ebr": 0, "dsp": 0}  # fmt: skip

    def placing(name, *_):
        if name == "csr":
            raise place.Failure("csr: nextpnr: Unable to place cell")
        return figures

    monkeypatch.setattr(place, "place", placing)
    found, failed = place.run(["csr", "lerp"], [1], tmp_path, Path("none"))
    assert failed and list(found) == ["accumulator", "lerp"]
    printed = capsys.readouterr()
    assert printed.err == "place.py: csr: nextpnr: Unable to place cell\n"
    assert "lerp: 100.0 MHz (99.0 to 101.0), 1.00 of the accumulator; a -> b" in printed.out


def test_a_missing_command_is_one_line(tmp_path):
    with pytest.raises(place.Failure, match="small: .*/none: No such file or directory: run `make build`"):
        place.part_of("small", tmp_path, tmp_path / "none")


def test_each_part_is_a_module_of_kt27():
    assert not [name for name in place.PARTS if not (ROOT / f"rtl/verilog/{name}.v").is_file()]
    assert set(place.SHORT) <= set(place.PARTS)
