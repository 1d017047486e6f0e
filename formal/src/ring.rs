//! The claims about the ring points of the descriptor, generated from the definition of the ring: point `(dx, dy)` is
//! the sample of its row from `16 - dx` steps before.
//!
//! One arbitrary sample of each row is followed through the delays of the row: a memory holds it at the address of its
//! write until the address wraps around. `ring_taps_S` lets every address start anywhere and allows a reset at any
//! time. `ring_taps_S_aligned` starts with a reset, after which memories of equal length have equal addresses. A run
//! may also start long after a reset, with every address inside its memory, so that covers take few steps.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use crate::claim::{Claim, Hole, Mutant, Observe};

/// Number of points of a ring.
const POINTS: usize = 32;
/// Lines and steps from the newest sample back to the centre of the ring.
const CENTRE_DELAY: i64 = 16;
/// Radius of the ring of each scale pair, pixels.
const RADII: [u32; 2] = [12, 16];
/// Word length of a sample: sign and MaxDOG.
const SAMPLE_BITS: usize = 16;
/// Steps after which an address that started beyond its memory has wrapped.
const WRAP_STEPS: usize = 32;

/// Generates the claims about both rings.
pub fn claims() -> Vec<Claim> {
    (0..RADII.len()).flat_map(|scale| [false, true].map(|aligned| Wrapper::new(scale, aligned).claim())).collect()
}

/// Returns the rows of a ring by their lines before the newest one. A row lists its points in ascending order, each as
/// its delay in steps from the newest sample and its number.
fn rows_by_line(radius: u32) -> BTreeMap<i64, Vec<(usize, usize)>> {
    let mut rows: BTreeMap<i64, Vec<(usize, usize)>> = BTreeMap::new();
    for point in 0..POINTS {
        let angle = 2.0 * PI * point as f64 / POINTS as f64;
        let [dx, dy] = [angle.cos(), angle.sin()].map(|part| (f64::from(radius) * part).round() as i64);
        rows.entry(CENTRE_DELAY - dy).or_default().push(((CENTRE_DELAY - dx) as usize, point));
    }
    rows.values_mut().for_each(|row| row.sort_unstable());
    rows
}

/// Returns the rows of a ring, the one with the newest samples first.
pub(crate) fn ring_rows(radius: u32) -> Vec<Vec<(usize, usize)>> {
    rows_by_line(radius).into_values().collect()
}

/// Returns the rows of a ring that come from a line memory: bit `k - 1` for the row `k` lines before the newest.
pub(crate) fn ring_taps(radius: u32) -> u64 {
    rows_by_line(radius).into_keys().filter(|line| *line > 0).fold(0, |taps, line| taps | 1 << (line - 1))
}

/// The parts of a wrapper under construction.
struct Wrapper {
    scale: usize,
    aligned: bool,
    signals: String,
    /// Statements of the clocked block.
    steps: String,
    properties: String,
    observe: String,
    /// Names of the address registers, by the length of their memory.
    addresses: BTreeMap<usize, Vec<String>>,
    /// Conditions that every address is inside its memory.
    inside: Vec<String>,
}

impl Wrapper {
    fn new(scale: usize, aligned: bool) -> Self {
        let [signals, steps, properties, observe] = Default::default();
        let (addresses, inside) = Default::default();
        let mut wrapper = Self { scale, aligned, signals, steps, properties, observe, addresses, inside };
        for (row, points) in ring_rows(RADII[scale]).iter().enumerate() {
            wrapper.add_row(row, points);
        }
        wrapper
    }

    /// Adds a sample of a row, followed from point to point.
    fn add_row(&mut self, row: usize, points: &[(usize, usize)]) {
        let input = slice("rows", row);
        self.signals += &format!(
            "  (* anyseq *) reg choose_{row};\n  reg [5:0] age_{row} = 6'd0;\n  reg [{top}:0] sample_{row};\n  \
             wire take_{row} = choose_{row} && age_{row} == 6'd0 && steps == 6'd{WRAP_STEPS};\n",
            top = SAMPLE_BITS - 1
        );
        self.steps += &format!(
            "    if (reset)\n      age_{row} <= 6'd0;\n    else if (advance && take_{row}) begin\n      \
             age_{row} <= 6'd1;\n      sample_{row} <= {input};\n    end else if (advance && age_{row} != 6'd0 && \
             age_{row} != 6'd63)\n      age_{row} <= age_{row} + 6'd1;\n"
        );
        self.add_assert(&format!("settled_{row}"), &format!("age_{row} == 6'd0 || steps == 6'd{WRAP_STEPS}"));
        let mut at = 0;
        for &(step, point) in points {
            match step - at {
                0 => {}
                distance @ 1..=3 => self.add_registers(row, point, at, distance),
                distance => self.add_memory(row, point, at, distance - 1),
            }
            at = step;
            let output = slice("points", point);
            match step {
                0 => self.add_assert(&format!("point_{point}"), &format!("{output} == {input}")),
                _ => self.add_assert(
                    &format!("point_{point}"),
                    &format!("age_{row} != 6'd{step} || {output} == sample_{row}"),
                ),
            }
        }
    }

    /// Adds a delay of registers: the sample is in each of them in turn.
    fn add_registers(&mut self, row: usize, point: usize, at: usize, distance: usize) {
        for step in 1..distance {
            let register = format!("\\dut.point_{point}_delayed_{step} ");
            self.signals += &format!("  (* hierconn *) wire [{}:0] {register};\n", SAMPLE_BITS - 1);
            let name = format!("point_{point}_delayed_{step}");
            self.add_assert(&name, &format!("age_{row} != 6'd{} || {register}== sample_{row}", at + step));
        }
    }

    /// Adds a delay by a memory of `length` words, which stores the sample when it is `at` steps old.
    fn add_memory(&mut self, row: usize, point: usize, at: usize, length: usize) {
        let bits = length.next_power_of_two().trailing_zeros();
        let top = bits - 1;
        let [position, slot, watched] =
            ["position", "slot", "watched"].map(|name| format!("\\dut.point_{point}_{name} "));
        self.signals += &format!(
            "  (* hierconn *) wire [{top}:0] {position};\n  (* hierconn *) wire [{top}:0] {slot};\n  \
             (* hierconn *) wire [{}:0] {watched};\n  reg [{top}:0] slot_{point};\n  assign {slot}= slot_{point};\n  \
             wire [6:0] address_{point} = {{1'b0, slot_{point}}} + age_{row} - 7'd{at};\n",
            SAMPLE_BITS - 1
        );
        self.observe += &format!(
            "wire [{top}:0] point_{point}_slot;\nwire [{}:0] point_{point}_watched = \
             point_{point}_memory[point_{point}_slot];\n",
            SAMPLE_BITS - 1
        );
        let taken = if at == 0 { format!("take_{row}") } else { format!("age_{row} == 6'd{at}") };
        self.steps += &format!("    if (advance && {taken}) slot_{point} <= {position};\n");
        if length != 1 << bits {
            self.add_assert(&format!("inside_{point}"), &format!("{position}< {length} || steps <= {position}"));
            self.inside.push(format!("{position}< {length}"));
        }
        self.add_assert(
            &format!("kept_{point}"),
            &format!(
                "age_{row} <= 6'd{at} || age_{row} > 6'd{} || (slot_{point} < {length} && {watched}== sample_{row} && \
                 {position}== (address_{point} >= {length} ? address_{point} - {length} : address_{point}))",
                at + length
            ),
        );
        self.addresses.entry(length).or_default().push(position);
    }

    fn add_assert(&mut self, name: &str, property: &str) {
        self.properties += &format!("    {name}: assert ({property});\n");
    }

    fn claim(mut self) -> Claim {
        let module = format!("ring_taps_{}", self.scale);
        let file = format!("{module}.v");
        let (name, statement) = if self.aligned {
            for (length, group) in std::mem::take(&mut self.addresses) {
                for (at, pair) in group.windows(2).enumerate() {
                    self.add_assert(&format!("aligned_{length}_{at}"), &format!("!begun || {}== {}", pair[0], pair[1]));
                    self.inside.push(format!("{}== {}", pair[0], pair[1]));
                }
            }
            self.properties += &format!("    if (!begun) assume (reset || steps == 6'd{WRAP_STEPS});\n");
            let statement = "The same, and from a reset on memories of one length have one address.";
            (format!("{module}_aligned"), statement.to_owned())
        } else {
            let statement = format!(
                "Point i of ring {}, at round({} (cos, sin)(2 pi i / 32)) = (dx, dy), is the sample of its row 16 - dx \
                 steps before, i = 0 .. 31, wherever the addresses begin and whatever `reset` does, from {WRAP_STEPS} \
                 steps after a reset on.",
                self.scale, RADII[self.scale]
            );
            (module.clone(), statement)
        };
        self.properties += &format!(
            "    if (!begun) assume (steps == 6'd0 || (steps == 6'd{WRAP_STEPS} && {}));\n",
            self.inside.join(" && ")
        );
        // Not vacuous: a sample is followed and the ring holds data.
        self.properties += "    taken: cover (age_0 == 6'd1 && points != 512'd0);\n";
        let (rows_top, points_top) = (SAMPLE_BITS * ring_rows(RADII[self.scale]).len() - 1, SAMPLE_BITS * POINTS - 1);
        let Self { signals, steps, properties, .. } = &self;
        let properties = format!(
            "// {name}: each point of the ring is the sample of its row with the delay of the point.
module {name}_properties (input clock);
  (* anyseq *) reg reset, advance;
  (* anyseq *) reg [{rows_top}:0] rows;
  wire [{points_top}:0] points;
  {module} dut (.clock(clock), .reset(reset), .advance(advance), .rows(rows), .points(points));

  reg begun = 0;
  // Steps since a reset.
  reg [5:0] steps;
{signals}
  always @(posedge clock) begin
    begun <= 1;
    if (reset)
      steps <= 6'd0;
    else if (advance && steps != 6'd{WRAP_STEPS})
      steps <= steps + 6'd1;
{steps}  end

  always @(posedge clock) begin
{properties}  end
endmodule
"
        );
        let mutant = |from: &str, to: &str| Mutant { file: file.clone(), from: from.into(), to: to.into() };
        let mutants = match self.scale {
            0 => vec![
                mutant("point_11_position == 4'd12", "point_11_position == 4'd11"),
                mutant("point_24 <= point_24_delayed_1", "point_24 <= point_25"),
                mutant("    point_31, point_30,", "    point_30, point_31,"),
            ],
            _ => vec![
                mutant("point_14_position == 5'd28", "point_14_position == 5'd29"),
                mutant(
                    "point_17_memory[point_17_position] <= rows[143:128]",
                    "point_17_memory[point_17_position] <= rows[127:112]",
                ),
                mutant("point_2 <= rows[95:80]", "point_2 <= point_14"),
            ],
        };
        // Texts of the lines with survivors of the default drawing.
        let lines: &[&str] = match self.scale {
            0 => &["if (reset)"],
            _ => &["if (reset)", "_position <= point_"],
        };
        let reason = format!(
            "Where an address begins changes no output as long as memories of one length have one address, of which \
             `{module}_aligned` speaks; its proof detects these mutations."
        );
        let hole =
            Hole { number: 1, file: file.clone(), lines: lines.iter().map(|&line| line.into()).collect(), reason };
        Claim {
            top: Some(format!("{name}_properties")),
            name,
            statement,
            sources: vec![file.clone()],
            properties,
            depth: 2,
            cover: 4,
            fault: 4,
            mutants,
            observe: vec![Observe { file, text: self.observe }],
            holes: if self.aligned { Vec::new() } else { vec![hole] },
            ..Claim::default()
        }
    }
}

/// Returns the part select of element `index` of a packed signal.
fn slice(signal: &str, index: usize) -> String {
    format!("{signal}[{}:{}]", SAMPLE_BITS * (index + 1) - 1, SAMPLE_BITS * index)
}
