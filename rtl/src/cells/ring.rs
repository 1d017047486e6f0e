//! The ring around a centre: `MaxDOG(p + o_i)` and its sign at 32 points, and the descriptor bits.
//!
//! Point `(dx, dy)` of the ring is the sample `16 - dy` lines and `16 - dx` steps before the newest one, whatever the
//! radius, so all scale pairs have the same centre. The lines come from a line delay. In a row with two points the
//! delay chain of the right point feeds the left one, so at most `2 dx` samples are stored.

use hoverlock_reference::features::maxlbp::{MAX_RING_RADIUS, Ring};
use rust_hdl::prelude::*;

use super::{
    Points, Response,
    delay::{LONGEST_IN_REGISTERS, address_bits},
    low,
};
use crate::design::{DOG_BITS, RING_RADII, SIGNED_BITS};

/// Lines and steps from the newest sample to the centre.
pub const RING_REACH: i32 = MAX_RING_RADIUS as i32;

/// The rows of the ring of a scale pair as lines before the newest one, ascending. Each row has its points as steps
/// before the newest sample, ascending, with the number of the point.
pub fn rows(scale: usize) -> Vec<(usize, Vec<(usize, usize)>)> {
    let mut rows: Vec<(usize, Vec<(usize, usize)>)> = Vec::new();
    for (i, &(dx, dy)) in Ring::of_radius(RING_RADII[scale] as u32).0.iter().enumerate() {
        let (line, step) = ((RING_REACH - dy) as usize, (RING_REACH - dx) as usize);
        match rows.iter_mut().find(|row| row.0 == line) {
            Some(row) => row.1.push((step, i)),
            None => rows.push((line, vec![(step, i)])),
        }
    }
    rows.sort_unstable();
    rows.iter_mut().for_each(|row| row.1.sort_unstable());
    rows
}

/// The 32 points of one ring in parallel.
#[derive(LogicBlock)]
pub struct RingTaps<const IN: usize> {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high, of the memories' address counters.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// Sign and MaxDOG of the rows that have points, the newest lowest.
    pub rows: Signal<In, Bits<IN>>,
    /// Sign and MaxDOG of point `i`, point 0 lowest.
    pub points: Signal<Out, Points>,
    _scale: usize,
    _delayed: Vec<Vec<u64>>,
}

impl<const IN: usize> RingTaps<IN> {
    /// The ring of a scale pair.
    pub fn new(scale: usize) -> Self {
        Self {
            clock: Signal::default(),
            reset: Signal::default(),
            advance: Signal::default(),
            rows: Signal::default(),
            points: Signal::default(),
            _scale: scale,
            _delayed: vec![vec![0; 2 * RING_REACH as usize + 1]; IN / SIGNED_BITS],
        }
    }
}

impl<const IN: usize> Logic for RingTaps<IN> {
    fn update(&mut self) {
        let inputs = self.rows.val();
        if self.clock.pos_edge() && self.advance.val() {
            for (row, delayed) in self._delayed.iter_mut().enumerate() {
                delayed.insert(0, inputs.get_bits::<SIGNED_BITS>(SIGNED_BITS * row).to_u64());
                delayed.pop();
            }
        }
        let mut points = self.points.val();
        for (row, (_, taps)) in rows(self._scale).iter().enumerate() {
            for &(step, i) in taps {
                let point = match step {
                    0 => inputs.get_bits::<SIGNED_BITS>(SIGNED_BITS * row),
                    _ => self._delayed[row][step - 1].into(),
                };
                points.set_bits(SIGNED_BITS * i, point);
            }
        }
        self.points.next = points;
    }

    fn connect(&mut self) {
        self.points.connect();
    }

    fn hdl(&self) -> Verilog {
        // Rings of one radius are one module.
        let radius = RING_RADII[self._scale];
        let scale = RING_RADII.iter().position(|known| *known == radius).unwrap_or(self._scale);
        let mut text = format!("// module: ring_taps_{scale}\n");
        let mut wires = vec![String::new(); 32];
        for (row, (line, taps)) in rows(scale).iter().enumerate() {
            text += &format!("// {line} lines before the newest\n");
            let mut signal = format!("rows[{}:{}]", SIGNED_BITS * (row + 1) - 1, SIGNED_BITS * row);
            let mut at = 0;
            for &(step, i) in taps {
                if step > at {
                    let name = format!("point_{i}");
                    text += &delay_body(&format!("point_{i}_"), &signal, &name, SIGNED_BITS, step - at);
                    signal = name;
                    at = step;
                }
                wires[i] = signal.clone();
            }
        }
        wires.reverse();
        let lines: Vec<String> = wires.chunks(8).map(|eight| eight.join(", ")).collect();
        Verilog::Custom(format!("{text}\nalways @(*)\n  points = {{\n    {}\n  }};\n", lines.join(",\n    ")))
    }
}

/// Verilog of `output[n] = input[n - steps]`: declarations and processes. Internal names begin with the prefix.
fn delay_body(prefix: &str, input: &str, output: &str, bits: usize, steps: usize) -> String {
    let top = bits - 1;
    if steps <= LONGEST_IN_REGISTERS {
        let (mut declarations, mut body, mut delayed) = (String::new(), String::new(), input.to_owned());
        for age in 1..=steps {
            let name = if age == steps { output.to_owned() } else { format!("{prefix}delayed_{age}") };
            declarations += &format!("reg [{top}:0] {name};\n");
            body += &format!("    {name} <= {delayed};\n");
            delayed = name;
        }
        return format!("{declarations}\nalways @(posedge clock)\n  if (advance) begin\n{body}  end\n");
    }
    let last = steps - 2;
    let size = address_bits(steps - 1);
    format!(
        "\
reg [{top}:0] {output};
(* ramstyle = \"MLAB\" *) reg [{top}:0] {prefix}memory [0:{last}];
reg [{p}:0] {prefix}position;

always @(posedge clock)
  if (reset)
    {prefix}position <= {size}'d0;
  else if (advance)
    {prefix}position <= {prefix}position == {size}'d{last} ? {size}'d0 : {prefix}position + {size}'d1;

always @(posedge clock)
  if (advance) begin
    {output} <= {prefix}memory[{prefix}position];
    {prefix}memory[{prefix}position] <= {input};
  end
",
        p = size - 1
    )
}

/// `maxlbp[i] = centre >= MaxDOG_i`, `sign[i] = sign_i`, one step.
#[derive(LogicBlock, Default)]
pub struct RingComparator {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// `DOG_k` at the centre.
    pub centre: Signal<In, Response>,
    /// The ring.
    pub points: Signal<In, Points>,
    /// MaxLBP bits.
    pub maxlbp: Signal<Out, Bits<32>>,
    /// Sign bits.
    pub sign: Signal<Out, Bits<32>>,
}

impl Logic for RingComparator {
    fn update(&mut self) {
        if self.clock.pos_edge() && self.advance.val() {
            let (centre, points) = (self.centre.val().to_u64(), self.points.val());
            let (mut maxlbp, mut sign) = (0u64, 0u64);
            for i in 0..32 {
                let point = points.get_bits::<SIGNED_BITS>(SIGNED_BITS * i).to_u64();
                maxlbp |= u64::from(centre >= low(point, DOG_BITS)) << i;
                sign |= (point >> DOG_BITS) << i;
            }
            self.maxlbp.next = maxlbp.into();
            self.sign.next = sign.into();
        }
    }

    fn connect(&mut self) {
        self.maxlbp.connect();
        self.sign.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom(
            "\
// module: ring_comparator
integer i;

always @(posedge clock)
  if (advance)
    for (i = 0; i < 32; i = i + 1) begin
      maxlbp[i] <= centre >= points[SIGNED_BITS * i +: DOG_BITS];
      sign[i]   <= points[SIGNED_BITS * i + DOG_BITS];
    end
"
            .into(),
        )
    }
}
