//! Formal verification: claims about Verilog, proved for all inputs by k-induction (Sheeran, Singh and Stalmarck 2000).
//! The base case is that no property is violated within `k` steps of reset, the induction step that `k` steps without a
//! violation are never followed by one.
//!
//! A claim is a wrapper in SystemVerilog with `assert`, `assume` and `cover`, and a TOML file with its statement, the
//! modules it is about and the parameters of the proof. Yosys converts both into a transition system, `yosys-smtbmc`
//! unrolls it, and Yices solves it. Covers show that a claim is not vacuous. Mutants, which are faults inserted into
//! the Verilog, must make the proof fail.
//!
//! | module | its one job |
//! |---|---|
//! | [`claim`] | a claim: statement, properties and parameters of the proof |
//! | [`shipped`] | the claims about the emitted Verilog |
//! | [`composition`] | the claims as one theorem, with what guarantees each assumption |
//! | [`shape`] | the numbers of a design that claims depend on |
//! | `wiring` | generates the claim about connections from a table |
//! | `ring` | generates the claims about the ring points |
//! | `library` | reusable properties of buses and streams |
//! | [`prove`] | runs proofs, covers and mutants of a claim |
//! | [`coverage`] | classifies mutations that Yosys draws |
//! | `system` | unrolls a transition system into queries |
//! | [`engine`] | runs Yosys and the solver as processes |
//! | `replay` | writes a counter-example as steps and as a test |
//! | [`rounding`] | worst-case errors and saturation, from the coefficients of a design |

pub mod claim;
pub mod composition;
pub mod coverage;
pub mod engine;
mod library;
pub mod prove;
mod replay;
mod ring;
pub mod rounding;
pub mod shape;
pub mod shipped;
mod system;
mod wiring;
