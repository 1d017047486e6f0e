"""Handles and values: widths, signs, memories, hierarchy, and what is refused."""

from pathlib import Path

import numpy
import pytest
from test_overrides import verilators

import hoverlock
from hoverlock import Clock, ClockCycles, Design, FallingEdge, NoSuchSignal, RangeError, RisingEdge, Timer, ValueChange, simulate

design = Design("designs/wide.v", top="wide", internals=["u_store.cells"])


@hoverlock.test()
async def wide_values_are_read_and_written_whole(dut):
    value = 0x9_8765_4321_0FED_CBA9_8765_4321
    dut.a.value = value
    await Timer(1, "ns")
    assert dut.a.value == value and len(dut.a) == 100
    assert int(dut.a_inverted.value) == (1 << 100) - 1 - value
    assert dut.a.value[3:0] == 1 and dut.a.value[0] == 1 and dut.a.value[99:36] == value >> 36
    assert ~dut.a.value == dut.a_inverted.value
    assert dut.a.value.buff == value.to_bytes(13, "big")
    dut.a.value = -1
    await Timer(1, "ns")
    assert dut.a_inverted.value == 0
    for bad in (1 << 100, -(1 << 99) - 1):
        with pytest.raises(RangeError, match="100 bits"):
            dut.a.value = bad


@hoverlock.test()
async def the_name_of_a_value_may_be_made_at_run_time(dut):
    """The usual name is known by its object; another object of the same text is looked for."""

    class Name(str):
        """Not interned by ``setattr``, which makes one object of equal strings."""

    name = Name("value")
    setattr(dut.s, name, 5)
    await Timer(1, "ns")
    assert dut.s.value == 5 and getattr(dut.s, name) == 5 and int(getattr(dut.s, name)) == 5
    with pytest.raises(RangeError):
        setattr(dut.s, name, 256)
    for attribute in ("value", name, "width"):
        with pytest.raises(AttributeError):
            delattr(dut.s, attribute)
    with pytest.raises(AttributeError, match="'s' has no attribute 'valu'"):
        dut.s.valu  # noqa: B018


@hoverlock.test()
async def signed_values_are_read_and_out_of_range_ones_refused(dut):
    for value in (-128, -1, 0, 5, 127, 255):
        dut.s.value = value
        await Timer(1, "ns")
        assert dut.s.value.signed_integer == (value if value < 128 else value - 256)
        assert dut.s_twice.value.to_signed() == 2 * dut.s.value.to_signed()
    for bad in (256, -129, 1 << 70):
        with pytest.raises(RangeError):
            dut.s.value = bad
    for kind in (OverflowError, ValueError):
        with pytest.raises(kind):
            dut.s.value = 300
    for bad in (1.5, None, [1]):
        with pytest.raises(TypeError):
            dut.s.value = bad


@hoverlock.test()
async def values_compare_and_calculate_as_numbers(dut):
    dut.s.value = "0010_1010"
    await Timer(1, "ns")
    value = dut.s.value
    assert value == 42 and value != 41 and value > 41 and 43 > value
    assert value + 1 == 43 and 100 - value == 58 and value // 5 == 8 and value & 2 == 2 and 1 << dut.s.value[1] == 2
    assert value == "00101010" and str(value) == "00101010" and f"{value:#x}" == "0x2a" and value.binstr == "00101010"
    assert [10, 20, 30][dut.s.value[2]] == 10 and bool(value) and hash(value) == hash(42) and value.is_resolvable
    assert {42: "x"}[value] == "x" and abs(value) == 42 and divmod(value, 5) == (8, 2)
    with pytest.raises(ValueError, match="8 digits"):
        dut.s.value = "01x0"
    with pytest.raises(IndexError):
        value[8]


@hoverlock.test()
async def inputs_are_copied_by_value(dut):
    dut.s.value = 3
    await Timer(1, "ns")
    old = dut.s.value
    dut.s.value = dut.s.value + 1
    await Timer(1, "ns")
    assert old == 3 and dut.s.value == 4


@hoverlock.test()
async def memories_are_read_and_written(dut):
    Clock(dut.clk, 10, "ns").start()
    dut.write.value, dut.write_at.value, dut.write_data.value = 1, 5, 0xBEEF
    await RisingEdge(dut.clk)
    await RisingEdge(dut.clk)
    cells = dut.u_store.cells
    assert int(cells[5].value) == 0xBEEF and len(cells) == 16 and cells.value[5] == 0xBEEF
    dut.write.value = 0
    cells[5].value = 7
    cells[6].value = -1
    await Timer(1, "ns")
    assert cells[5].value == 7 and cells[6].value == 0xFFFF
    cells.value = range(16)
    await Timer(1, "ns")
    assert cells.value == list(range(16))
    with pytest.raises(IndexError, match="0 to 15"):
        cells[16]
    with pytest.raises(RangeError):
        cells[0].value = 1 << 16
    with pytest.raises(IndexError, match="17 values"):
        cells.value = range(17)


@hoverlock.test()
async def wrong_names_are_answered_with_the_nearest(dut):
    with pytest.raises(NoSuchSignal, match="no signal 'a_invertd'.*nearest: a_inverted"):
        dut.a_invertd
    with pytest.raises(AttributeError):
        dut.a_invertd
    assert not hasattr(dut, "nothing_like_it") and "a" in dut
    with pytest.raises(TypeError, match=r"wide\.s\.value = 3"):
        dut.s = 3
    with pytest.raises(NoSuchSignal):
        dut.anything = 3
    with pytest.raises(hoverlock.NotWritable, match="output"):
        dut.s_twice.value = 1
    assert "u_store" in dir(dut) and dut.u_store.cells._name == "cells"


generated = Design("designs/generated.sv", top="generated", internals=["*"])


def test_everything_public_builds_whatever_is_declared():
    async def bench(dut):
        Clock(dut.clk, 10, "ns").start()
        await ClockCycles(dut.clk, 3)
        # Registers of generate blocks, an enumeration of a package.
        assert [int(dut.lane[n].q.value) for n in range(4)] == [0] * 4 and dut.pair[1].level.value == 4
        assert dut.state.value_name == "BUSY"
        await Timer(1, "ns")
        dut.lane[2].q.value = 0
        await hoverlock.ReadWrite()
        assert dut.out.value == 0b1011
        dut.state.value = "IDLE"
        assert dut.lane[2].q._path == "generated.lane[2].q" and dut.lane[2].q._name == "q"
        # What is no number is not there: read as one, it would be memory of something else.
        for name in ("i", "numbers", "tick", "link__Viftop"):
            assert name not in dut, name

    simulate(generated, bench)


@pytest.mark.parametrize(("given", "name", "read"), [
    ({"WIDTH": "6"}, "WIDTH", 6), ({"WIDTH": "32'd5"}, "WIDTH", 5), ({"WIDTH": 7}, "WIDTH", 7), ({"NAME": "plain"}, "NAME", "plain"),
    ({"NAME": '"12"'}, "NAME", "12"), ({"GAIN": 2.25}, "GAIN", 2.25), ({"GAIN": "0.5"}, "GAIN", 0.5),
    ({"KEY": 3 << 90}, "KEY", 3 << 90), ({}, "KEY", 1),
])  # fmt: skip
def test_parameters_are_what_they_say(given, name, read):
    with hoverlock.Session(generated.changed(parameters=given, internals=[])) as session:
        value = session.dut[name].value
        assert value == read and type(value) is type(read)
        if name == "WIDTH":
            assert len(session.dut.out) == read


def test_a_bit_of_a_signal_has_edges():
    async def bench(dut):
        seen = []

        async def watch(trigger, label):
            while True:
                await trigger
                seen.append((label, hoverlock.get_sim_time("ns")))

        for trigger, label in ((RisingEdge(dut.lines[3]), "up"), (FallingEdge(dut.lines[3]), "down"), (ValueChange(dut.lines[0]), "any"),
                               (RisingEdge(dut.out[1]), "out")):
            hoverlock.start_soon(watch(trigger, label))
        Clock(dut.clk, 100, "ns").start()
        for value in (0b1000, 0b1001, 0b0010, 0b1010):
            await Timer(10, "ns")
            dut.lines.value = value
        await Timer(110, "ns")
        assert sorted(seen) == [("any", 20), ("any", 30), ("down", 30), ("out", 0), ("up", 10), ("up", 40)]
        assert repr(RisingEdge(dut.lines[3])) == "RisingEdge(lines[3])"
        with pytest.raises(TypeError, match=r"not <lines\[3:2\]>"):
            RisingEdge(dut.lines[3:2])

    simulate(generated, bench)


@pytest.mark.parametrize("verilator", verilators())
def test_bits_have_the_indices_of_their_declaration(verilator):
    async def bench(dut):
        dut.up.value = dut.from_one.value = dut.around.value = dut.long_up.value = 0
        dut.up[0].value = 1
        dut.from_one[1].value = 1
        dut.around[-2].value = 1
        dut.long_up[70].value = 1
        await Timer(1, "ns")
        assert dut.up_as_number.value == 0x80 and dut.from_one_as_number.value == 1
        assert dut.around_as_number.value == 0x20 and dut.long_as_number.value == 1
        assert dut.up[0].value == 1 and dut.up[7].value == 0 and dut.up[0:3].value == 8
        dut.up[4:7].value = 5
        dut.from_one[8:5].value = 0xA
        await Timer(1, "ns")
        assert dut.up.value == 0x85 and dut.from_one.value == 0xA1
        assert (dut.up._range, dut.from_one._range, dut.around._range, dut.counted._range) == ((0, 7), (8, 1), (-2, 3), (7, 0))
        assert repr(dut.up[4:7]) == "<up[4:7]>" and repr(RisingEdge(dut.from_one[8])) == "RisingEdge(from_one[8])"
        for wrong in (lambda: dut.up[8], lambda: dut.from_one[0], lambda: dut.up[7:4], lambda: dut.from_one[1:4], lambda: dut.up[-1]):
            with pytest.raises(IndexError):
                wrong()
        hoverlock.start_soon(rise(dut))
        await RisingEdge(dut.from_one[3])
        assert hoverlock.get_sim_time("ns") == 12

    async def rise(dut):
        await Timer(10, "ns")
        dut.from_one.value = 4

    simulate(Design("designs/ranges.v", top="ranges", verilator=verilator), bench)


def test_a_write_of_some_bits_after_an_edge_leaves_what_the_edge_made_of_the_others():
    async def bench(dut):
        Clock(dut.clk, 10, "ns").start()
        for _ in range(4):
            await RisingEdge(dut.clk)
            dut.count.value = 5
            await hoverlock.ReadOnly()
            assert dut.count.value == 5
        await RisingEdge(dut.clk)
        dut.count[7].value = 1
        await hoverlock.ReadOnly()
        assert dut.count.value == dut.counted.value == 0x86

    simulate(Design("designs/ranges.v", top="ranges", internals=["count"]), bench)


@pytest.mark.parametrize(("choice", "expected"), [("zeros", {0b0001}), ("ones", {0b1101}), ("random", {0b0001, 0b0101, 0b1001, 0b1101})])
def test_digits_that_a_signal_cannot_have(caplog, choice, expected):
    from hoverlock.cocotb.types import LogicArray

    async def bench(dut):
        with pytest.raises(ValueError, match=r"'XXXX00Z1' is not a value of 'lines'.*Verilator has no X"):
            dut.lines.value = "XXXX00Z1"
        found = set()
        with hoverlock.unknown.written_as(choice):
            for _ in range(60):
                dut.lines.value = LogicArray("0000XZ01")
                await hoverlock.ReadWrite()
                found.add(int(dut.lines.value))
                dut.lines[1].value = "X"
            assert found == expected
        with pytest.raises(ValueError, match="no choice 'x'"):
            hoverlock.unknown.set_choice("x")

    with caplog.at_level("WARNING", logger="hoverlock"):
        simulate(generated, bench, seed=3)
    assert caplog.text.count("are written as") == 1 and f"written as {choice}" in caplog.text


odd = Design(Path(__file__).resolve().parents[2] / "tests" / "designs" / "odd.sv", top="odd", internals=["*"])


def test_reals_strings_fields_and_arrays_of_any_shape():
    async def bench(dut):
        dut.grid.value = [[1, 2, 3], [4, 5, 6]]
        dut.gain.value = 1.25
        Clock(dut.clk, 10, "ns").start()
        await Timer(1, "ns")
        assert dut.corner.value == 6 and dut.scaled.value == 3.75 and float(dut.state) == 1.25
        assert dut.text.value == b"tick" and dut.text._type == "GPI_STRING" and dut.gain._type == "GPI_REAL"
        assert [[int(e) for e in row] for row in dut.grid.value] == [[1, 2, 3], [4, 5, 6]]
        assert dut.grid[1][2].value == 6 and len(dut.grid) == 2 and len(dut.grid[0]) == 3
        assert [[e._path for e in row] for row in dut.grid][1][0] == "odd.grid[1][0]"
        assert numpy.asarray(dut.grid).tolist() == [[1, 2, 3], [4, 5, 6]]
        with pytest.raises(IndexError, match=r"address 2 is outside of 'grid', which has 0 to 1"):
            dut.grid[2]
        with pytest.raises(IndexError, match=r"address 3 is outside of 'grid\[1\]', which has 0 to 2"):
            dut.grid[1][3]
        dut.grid[1][2].value = 11
        dut.deep[-1].value = -1
        dut.deep[1].value = 1 << 70
        dut.text.value = "written"
        dut.beat.value = 0xABC
        dut.beat.body.rest.value = 5
        await Timer(1, "ns")
        assert dut.corner.value == 11 and dut.text.value == b"written"
        assert dut.deepest.value == (1 << 71) - 1 and dut.deep[1].value == 1 << 70
        assert numpy.asarray(dut.deep).tolist() == [0, (1 << 71) - 1, 0, 1 << 70]
        with pytest.raises(ValueError, match="does not fit 'deep'"):
            dut.deep[0].value = 1 << 71
        assert dut.beat.value == 0xAB5 and dut.beat.tag.value == 0xA
        assert dut.beat.body.value == 0xB5 and dut.beat.body.low.value.signed_integer == -5
        with pytest.raises(AttributeError, match="its fields are tag, body, body.low, body.rest"):
            dut.beat.nothing
        with pytest.raises(AttributeError, match="no signal 'loose.value' in 'odd'"):
            dut.loose.value
        with pytest.raises(AttributeError, match="'numbers' of 'odd' cannot be accessed"):
            dut.numbers
        with pytest.raises(TypeError, match="takes bytes or a string"):
            dut.text.value = 3
        with pytest.raises(hoverlock.NotWritable, match="scaled"):
            dut.scaled.value = 1.0

    simulate(odd, bench)


@pytest.mark.parametrize("verilator", verilators())
def test_fields_of_unpacked_structures_and_arrays_of_reals(verilator):
    async def bench(dut):
        Clock(dut.clk, 10, "ns").start()
        dut.grid[1][2].value = 6
        dut.levels.value = [0.5, 1.5, 2.5, -3.5]
        dut.plane[1][2].value = -0.25
        dut.many[3].x.value, dut.table_of[1][-1].x.value = 9, 5
        dut.mixed.bytes.value, dut.mixed.note.value = [1, 42, 3], "none"
        dut.mixed.pair.low.value = 5
        dut.mixed.inner.y.value = -7
        await Timer(25, "ns")
        assert dut.mixed.inner.x.value == 9 ^ 5
        if verilator is not None:
            assert dut.mixed.mode.value_name == "RUN"
            assert dut.mixed.level.value == 1.25 and dut.mixed.deep.value == 0x666
            dut.mixed.deep.value, dut.mixed.level.value = 1 << 70, 3.5
            await hoverlock.ReadWrite()
            assert dut.mixed.deep.value == 1 << 70 and dut.mixed.level.value == 3.5
        assert [int(byte) for byte in dut.mixed.bytes.value] == [1, 42, 3] and dut.mixed.bytes[2].value == 42
        assert dut.mixed.mode.value == 2 and dut.mixed.inner.y.value.signed_integer == -10
        assert dut.mixed.note.value == b"none"
        assert dut.levels.value == [0.5, 1.5, 2.5, -3.5] and float(dut.levels[4]) == -3.5 and int(dut.levels[3]) == 2
        assert numpy.asarray(dut.plane).tolist() == [[0, 0, 0], [0, 0, -0.25]] and numpy.asarray(dut.levels).dtype == float
        assert repr(dut.levels) == "<internal levels real [1:4]>"
        with pytest.raises(TypeError, match="'levels' takes numbers, not high"):
            dut.levels[1].value = "high"

    defines = {} if verilator is None else {"WIDE_FIELDS": "1"}
    simulate(Design(odd.sources, top="odd", internals=["*"], verilator=verilator, defines=defines), bench)
