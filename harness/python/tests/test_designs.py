"""Designs as others would bring them, driven as cocotb's users would: a FIFO, a UART, a small processor, a stream adapter."""

import random

import numpy as np
import pytest

import hoverlock
from hoverlock import (
    Clock,
    ClockCycles,
    Design,
    Event,
    FallingEdge,
    First,
    Queue,
    ReadOnly,
    RisingEdge,
    Session,
    Timer,
    start_soon,
    with_timeout,
)
from hoverlock.bus import AxiMonitor, AxiSink, AxiSource, Frame

FOLDER = "../../tests/designs/"


async def reset(dut, cycles=3):
    Clock(dut.clk, 10, "ns").start()
    dut.rst.value = 1
    await ClockCycles(dut.clk, cycles)
    dut.rst.value = 0
    await RisingEdge(dut.clk)


# ---- the FIFO: driver, monitors, scoreboard


class Scoreboard:
    """What went in must come out, in order."""

    def __init__(self):
        self.expected = Queue()
        self.compared = 0

    def sent(self, word):
        self.expected.put_nowait(word)

    def received(self, word):
        assert word == self.expected.get_nowait(), f"word {self.compared} differs"
        self.compared += 1


async def watch(clk, valid, ready, data, log):
    """Logs each word that moves."""
    while True:
        await RisingEdge(clk)
        if valid.value and ready.value:
            log(int(data.value))


async def fifo_bench(dut, count=300, fill=0.6, drain=0.4):
    await reset(dut)
    width, board, full = len(dut.in_data), Scoreboard(), Event("was full")
    start_soon(watch(dut.clk, dut.in_valid, dut.in_ready, dut.in_data, board.sent))
    start_soon(watch(dut.clk, dut.out_valid, dut.out_ready, dut.out_data, board.received))

    async def drive():
        left = count
        while left:
            dut.in_valid.value = offered = random.random() < fill
            dut.in_data.value = random.getrandbits(width)
            await RisingEdge(dut.clk)
            while offered and not dut.in_ready.value:
                full.set()
                await RisingEdge(dut.clk)
            left -= offered
        dut.in_valid.value = 0

    async def take():
        while True:
            dut.out_ready.value = random.random() < drain
            await RisingEdge(dut.clk)

    start_soon(take())
    await with_timeout(drive(), 200, "us")
    while board.compared < count:
        await RisingEdge(dut.clk)
    assert board.expected.empty()
    await ReadOnly()
    assert dut.level.value == 0 and full.is_set()


@pytest.mark.parametrize("width, depth", [(8, 4), (1, 4), (33, 5), (64, 16)])
def test_a_fifo_of_any_shape(width, depth):
    design = Design(FOLDER + "fifo.v", top="fifo", parameters={"WIDTH": width, "DEPTH": depth})
    hoverlock.simulate(design, fifo_bench, seed=depth, wall_limit=60)


def test_a_fifo_that_takes_one_word_too_many_is_found():
    faulty = Design(FOLDER + "fifo.v", top="fifo", parameters={"FAULT": 1})
    with pytest.raises(AssertionError, match="differs"):
        hoverlock.simulate(faulty, fifo_bench, seed=1, wall_limit=60)


# ---- the UART: bits by time alone, at a speed that is not quite that of the design

DIVISOR = 8
BIT = DIVISOR * 10_000  # ps
uart = Design(FOLDER + "uart.v", top="uart", parameters={"DIVISOR": DIVISOR})


async def send_byte(line, byte, *, bit=BIT, stop=1):
    """Start bit, eight bits lowest first, stop bit."""
    for level in [0, *((byte >> at) & 1 for at in range(8)), stop]:
        line.value = level
        await Timer(round(bit), "ps")
    line.value = 1


async def hear_byte(line):
    """What a receiver makes of a line, looking in the middle of each bit."""
    await FallingEdge(line)
    await Timer(BIT * 3 // 2, "ps")
    byte = 0
    for at in range(8):
        byte |= int(line.value) << at
        await Timer(BIT, "ps")
    assert line.value == 1, "no stop bit"
    return byte


@hoverlock.test(design=uart, timeout_time=1, timeout_unit="ms")
async def a_uart_sends(dut):
    dut.rx.value = 1
    await reset(dut)
    for byte in [0x00, 0xFF, 0x55, *(random.getrandbits(8) for _ in range(5))]:
        heard = start_soon(hear_byte(dut.tx))
        dut.tx_data.value, dut.send.value = byte, 1
        await RisingEdge(dut.clk)
        dut.send.value = 0
        assert await heard == byte
        while dut.tx_busy.value:
            await RisingEdge(dut.clk)


# The sample of the stop bit is 9.5 bits after the start: a sender 4 % off is 0.38 bits off there, and is understood.
@hoverlock.test(design=uart, timeout_time=1, timeout_unit="ms")
@hoverlock.parametrize(off=[-0.04, -0.02, 0.0, 0.02, 0.04])
async def a_uart_understands_a_sender_that_is_a_little_off(dut, off):
    dut.rx.value = 1
    await reset(dut)
    for _ in range(10):
        byte = random.getrandbits(8)
        sending = start_soon(send_byte(dut.rx, byte, bit=BIT * (1 + off)))
        await with_timeout(RisingEdge(dut.rx_valid), 20 * BIT, "ps")
        assert dut.rx_data.value == byte and not dut.framing_error.value
        await sending
        await Timer(BIT, "ps")


@hoverlock.test(design=uart, timeout_time=1, timeout_unit="ms")
async def a_uart_reports_a_frame_without_a_stop_bit(dut):
    dut.rx.value = 1
    await reset(dut)
    start_soon(send_byte(dut.rx, 0xA5, stop=0))
    came = await First(RisingEdge(dut.framing_error), RisingEdge(dut.rx_valid))
    assert came is RisingEdge(dut.framing_error) and not dut.rx_valid.value
    # A sender at 4/5 of the speed is late by more than two bits: a 0 is in the place of the stop bit.
    await Timer(12 * BIT, "ps")
    start_soon(send_byte(dut.rx, 0x5A, bit=BIT * 1.25))
    await Timer(10 * BIT, "ps")
    assert dut.rx_data.value != 0x5A
    # And after a quiet time all is well.
    await Timer(20 * BIT, "ps")
    start_soon(send_byte(dut.rx, 0x3C))
    await RisingEdge(dut.rx_valid)
    assert dut.rx_data.value == 0x3C and not dut.framing_error.value


# ---- the processor: a small assembler, programs, and a model of the machine in Python

cpu = Design(FOLDER + "cpu.sv", top="cpu", internals=["state", "u_core.*"])
LOAD, GET, PUT, ADD, SUB, JUMP_IF, OUT, STOP = 0, 1, 2, 3, 4, 5, 6, 15


def program(*lines):
    return [(op << 12) | (operand & 0xFFF) for op, operand in lines]


def fibonacci(count):
    """a, b = b, a + b in data[0] and data[1], counted down in data[3]; data[4] is 1."""
    return program(
        (LOAD, 0), (PUT, 0), (LOAD, 1), (PUT, 1), (PUT, 4), (LOAD, count), (PUT, 3),
        (GET, 0), (OUT, 0), (ADD, 1), (PUT, 2), (GET, 1), (PUT, 0), (GET, 2), (PUT, 1),
        (GET, 3), (SUB, 4), (PUT, 3), (JUMP_IF, 7), (STOP, 0),
    )  # fmt: skip


def checksum(addresses):
    """The sum of what the bench has put into the data memory."""
    return program((LOAD, 0), *((ADD, at) for at in addresses), (OUT, 0), (STOP, 0))


def machine(code, data):
    """What the program gives, by the book."""
    data, out, pc, acc = list(data), [], 0, 0
    while True:
        op, operand = code[pc] >> 12, code[pc] & 0xFFF
        pc, at = pc + 1, operand & 15
        match op:
            case 0: acc = (operand - 0x1000 if operand & 0x800 else operand) & 0xFFFF
            case 1: acc = data[at]
            case 2: data[at] = acc
            case 3: acc = (acc + data[at]) & 0xFFFF
            case 4: acc = (acc - data[at]) & 0xFFFF
            case 5: pc = operand & 0xFF if acc else pc
            case 6: out.append(acc)
            case _: return out, data  # fmt: skip


async def run_program(dut, code, data):
    """Puts program and data into the memories, runs to the end, and gives what came out and what the data became."""
    dut.u_core.program_memory.value = code
    dut.u_core.data_memory.value = data
    await reset(dut)
    out = []
    while not dut.halted.value:
        await RisingEdge(dut.clk)
        if dut.out_valid.value:
            out.append(int(dut.out.value))
    assert dut.state.value_name == "HALT"
    return out, [int(word) for word in dut.u_core.data_memory.value]


@hoverlock.test(design=cpu, timeout_time=1, timeout_unit="ms")
async def a_processor_computes_fibonacci(dut):
    out, data = await run_program(dut, fibonacci(20), [0] * 16)
    expected = [0, 1]
    while len(expected) < 22:
        expected.append(expected[-1] + expected[-2])
    assert out == expected[:20] and data[:2] == expected[20:22]


@hoverlock.test(design=cpu, timeout_time=1, timeout_unit="ms")
async def a_processor_adds_up_a_memory(dut):
    words = [random.getrandbits(16) for _ in range(16)]
    out, data = await run_program(dut, checksum(range(16)), words)
    assert out == [sum(words) & 0xFFFF] and data == words


def test_a_processor_does_what_its_book_says():
    generator = random.Random(7)
    with Session(cpu) as session:
        for _ in range(20):
            # Straight-line programs of random instructions; the jumps are in the loop above.
            ops = [generator.choice([LOAD, GET, PUT, ADD, SUB, OUT]) for _ in range(60)]
            code = program(*((op, generator.getrandbits(12)) for op in ops), (STOP, 0))
            data = [generator.getrandbits(16) for _ in range(16)]
            assert session.run(run_program, code=code, data=data) == machine(code, data)


# ---- the AXI4-Stream width adapter, in several shapes


async def adapter_bench(dut, lengths=(1, 2, 3, 7, 16, 33), idle=0.3, stall=0.4):
    seed = hoverlock.running().seed
    generator = np.random.default_rng(seed)
    options = {"reset": dut.rst_n, "reset_active": False}
    source = AxiSource(dut, "s_axis_", dut.clk, **options)
    sink = AxiSink(dut, "m_axis_", dut.clk, **options)
    monitor = AxiMonitor(dut, "s_axis_", dut.clk, **options)
    source.pause(idle, seed=1)
    sink.pause(stall, seed=2)
    Clock(dut.clk, 10, "ns").start()
    await ClockCycles(dut.clk, 3)
    dut.rst_n.value = 1
    frames = [Frame(generator.integers(0, 256, n, dtype=np.uint8), error=int(generator.integers(2))) for n in lengths]
    for frame in frames:
        source.send(frame)
    for frame in frames:
        for received in (await with_timeout(sink.recv(), 200, "us"), await monitor.recv()):
            assert bytes(received) == bytes(frame), f"seed {seed}, length {len(frame)}"
            assert received.error == frame.error
    assert sink.violations == [] and len(sink) == 0


@pytest.mark.parametrize("s, m", [(1, 1), (4, 2), (2, 4), (3, 5), (8, 1), (1, 16)])
def test_a_stream_adapter_of_any_two_widths(s, m):
    design = Design(FOLDER + "axis_adapter.v", top="axis_adapter", parameters={"S": s, "M": m})
    hoverlock.simulate(design, adapter_bench, seed=100 * s + m, wall_limit=60)
