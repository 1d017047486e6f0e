//! Claims about Verilog, proved for all inputs: `base` (no violation within `k` steps of reset) and `step` (`k` steps
//! without a violation are followed by another), together a proof by k-induction (Sheeran, Singh and Stalmarck 2000).
//!
//! A claim is a wrapper in SystemVerilog with `assert`, `assume` and `cover`, and a TOML file that says what is
//! claimed, of which modules, and how it is proved. Yosys makes a transition system of both, `yosys-smtbmc` unrolls it,
//! Yices decides. A claim counts only with its covers, which show that it is not vacuous, and its mutants:
//! faults put into the Verilog that must make the proof fail.
//!
//! | module | its one reason |
//! |---|---|
//! | [`claim`] | what is claimed, and of what |
//! | [`library`] | rules of buses and streams for every design |
//! | [`prove`] | a claim to a verdict |
//! | [`engine`] | Yosys and the solver as processes |
//! | [`replay`] | a violation step by step, and as a test |
//! | `ring` | the claims about the ring points, from their definition |
//! | [`rounding`] | worst-case errors and saturation from a design's coefficients |

pub mod claim;
pub mod engine;
pub mod library;
pub mod prove;
pub mod replay;
mod ring;
pub mod rounding;
