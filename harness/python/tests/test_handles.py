"""Handles and values: widths, signs, memories, hierarchy, and what is refused."""

import pytest

import hoverlock
from hoverlock import Clock, Design, NoSuchSignal, RangeError, RisingEdge, Timer

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
    assert "u_store" in dir(dut) and dut.u_store.cells._name == "u_store.cells"
