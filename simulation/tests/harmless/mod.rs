//! Why a fault that no test finds is harmless: a claim that is proved with the fault in place, or a numbered hole.

use std::{path::Path, sync::LazyLock, time::Duration};

use hoverlock_formal::{
    claim::Claim,
    engine::Solver,
    prove::{FaultySource, Place, Status, Task, holds_with, run},
    shipped,
};

use crate::mutation::{Kind, Mutant, Source, by_hand, is_proved_equivalent, plain};

/// What shows that a fault is harmless.
#[derive(Clone, Copy)]
enum Shown {
    /// A claim of `formal/`, which holds with the fault; `*` in its name stands for the module's.
    By(&'static str),
    /// The same, of steps after a reset: that nothing counts before is a hole, `FIRST_SAMPLE`.
    Later(&'static str),
    /// An argument in words: a hole of `formal/README.md`, by its number.
    Hole(u32),
}

use Shown::{By, Hole, Later};

/// The module's name, or the instance's, or module/instance, each up to a `*`; kinds, a part of the original text, a
/// part of the fault, the reason, what shows it.
type Harmless = (&'static str, &'static [Kind], &'static str, &'static str, &'static str, Shown);

const RESETS: &[Kind] = &[Kind::Reset, Kind::ResetValue];
/// The argument from a claim about steps to the frame: the first sample that counts comes later.
const FIRST_SAMPLE: u32 = 10;
/// Outputs and upper bits that nothing uses.
const UNUSED: u32 = 16;
/// A flag wired to a reset, where rows are far enough apart.
const FLAG: u32 = 17;
/// What the record limit counts before row 17 of a frame.
const ABOVE: u32 = 21;
/// The bins before the first frame.
const FIRST_BINS: u32 = 25;
/// The size before the first frame.
const NO_SIZE: u32 = 24;
/// The held row in place of the last row.
const LAST_ROW: u32 = 23;
const POSITION: &str = "the address of a circular memory may begin anywhere";
const ROWS: &str = "what a reset leaves in the rows has left them within 64 steps";
const COUNTS: &str = "no frame has 2^19 features: 2^21 pixels, one maximum in 16 at most, two scale pairs";
const HARMLESS: &[Harmless] = &[
    ("delay(*", RESETS, "", "", POSITION, Later("delay")),
    (
        "flag_delay(8)",
        RESETS,
        "",
        "",
        "flags of ring points, data that come after those of the reset",
        Later("flag_delay"),
    ),
    ("ring_taps*", RESETS, "", "", POSITION, Later("*")),
    (
        "ring_taps*",
        &[Kind::Memory],
        "_memory[",
        "_position]",
        "memories of one length have one address",
        By("*_aligned"),
    ),
    (
        "ring_taps*",
        &[Kind::Comparison],
        "_position == ",
        "_position >= ",
        "an address never exceeds the last one",
        Later("*"),
    ),
    // The marker that a stage passes on starts the cursors of the decisions, where it is a stage of the wide smoother.
    ("row_look_back_border*", RESETS, "", "", ROWS, Later("row_look_back")),
    (
        "row_look_back_border(18, 1)",
        &[Kind::Pipeline],
        "outside ? border",
        "outside ? x",
        "of a look-back of one column only the first sample is outside",
        By("row_look_back"),
    ),
    ("row_look_ahead_border*", RESETS, "", "", ROWS, Later("row_look_ahead")),
    ("smoother_5/row_look_back*", RESETS, "", "", ROWS, Later("row_look_back")),
    ("smoother_5/row_look_ahead*", RESETS, "", "", ROWS, Later("row_look_ahead")),
    ("pulse_delay(24)", RESETS, "", "", ROWS, Later("row_look_ahead")),
    ("row_look_back*/flag_delay(4)", RESETS, "", "", ROWS, Later("row_look_back")),
    (
        "row_look_back*",
        &[Kind::Wiring],
        "reset",
        "first_delay_y",
        "the flag comes when the count is 0 already",
        Hole(FLAG),
    ),
    (
        "row_look_ahead*",
        &[Kind::Wiring],
        "reset",
        "loads",
        "the frame's marker comes when the count is 0 already",
        Hole(FLAG),
    ),
    (
        "row_look_ahead*",
        &[Kind::Wiring],
        "reset",
        "load_delay_y",
        "the frame's marker comes when the count is 0 already",
        Hole(FLAG),
    ),
    (
        "row_look_ahead(32)/pulse_delay*",
        &[Kind::Wiring],
        "last",
        "",
        "after the longest stage of a row no stage follows that needs its end",
        Hole(UNUSED),
    ),
    (
        "row_look_ahead_border*",
        &[Kind::Width],
        "remaining - 1",
        "",
        "the count begins at a power of two, so what follows has a bit less",
        Later("row_look_ahead"),
    ),
    (
        "row_look_ahead*",
        &[Kind::Operator],
        "remaining - ",
        "remaining + ",
        "the count begins at half of its range: counting up or down, it is 0 after the same number of steps",
        By("row_look_ahead_border"),
    ),
    ("sequencer", RESETS, "1'd0", "", "x and y are set as a frame begins, before they count", By("unset_registers")),
    ("sequencer", RESETS, "1'b0", "same", "sizes are compared again before a beat can be taken", By("sequencer")),
    (
        "sequencer",
        RESETS,
        "3'd0",
        "own",
        "the error bits of a frame are cleared as the next begins",
        By("unset_registers"),
    ),
    ("tail_counter", RESETS, "10'd0", "x", "x is set as the tail begins, before it counts", By("unset_registers")),
    (
        "sequencer",
        &[Kind::ResetValue],
        "1'b0",
        "1'h1",
        "a start counts in a step only, and the first step is a frame's first",
        By("sequencer"),
    ),
    (
        "csr",
        &[Kind::ResetValue],
        "11'd0",
        "",
        "before a frame has taken a size, none is possible either way",
        Hole(NO_SIZE),
    ),
    (
        "threshold",
        &[Kind::Comparison],
        "wanted > lowest",
        "wanted >= lowest",
        "the larger of two equal thresholds is either",
        By("threshold"),
    ),
    (
        "threshold",
        RESETS,
        "1'b0",
        "_",
        "the first frame clears the bins and takes the manual threshold, whatever the sum",
        Hole(FIRST_BINS),
    ),
    (
        "tail_counter",
        &[Kind::Comparison],
        "(line > ",
        "(line >= ",
        "in that line the late row is the last row, of which the held row is a copy",
        Hole(LAST_ROW),
    ),
    ("extractor", &[Kind::Width], "writer_count", "", COUNTS, Hole(UNUSED)),
    ("extractor", &[Kind::Width], "writer_dropped", "", COUNTS, Hole(UNUSED)),
    ("hoverlock_core", &[Kind::Width, Kind::Stuck], "extractor_count", "<< 19", COUNTS, Hole(UNUSED)),
    ("hoverlock_core", &[Kind::Width, Kind::Stuck], "extractor_dropped", "<< 19", COUNTS, Hole(UNUSED)),
    (
        "record_limit",
        &[Kind::Comparison],
        "(rows == last_row)",
        "(rows >= last_row)",
        "the rows of a band exceed the last one only above row 17, where the first band begins",
        Hole(ABOVE),
    ),
    ("smoother_5", &[Kind::Stuck], "row_start_y", "", "only the start_out of the wide smoother is used", Hole(UNUSED)),
];

/// The same of modules that the default design lacks.
const ELSEWHERE: &[Harmless] = &[
    ("pulse_delay(16)", RESETS, "", "", ROWS, Later("row_look_ahead")),
    ("tail_counter", RESETS, "11'd0", "x", "x is set as the tail begins, before it counts", By("unset_registers")),
    (
        "csr",
        &[Kind::Constant],
        "{record_limit_count, 15'd0",
        "",
        "its constants are the bits of a bank above the mode, the thresholds and the coefficients",
        Hole(UNUSED),
    ),
    ("hoverlock_core", &[Kind::Width], "extractor_count", ">> 1", COUNTS, Hole(UNUSED)),
    ("hoverlock_core", &[Kind::Width], "extractor_dropped", ">> 1", COUNTS, Hole(UNUSED)),
    ("scale_pair", &[Kind::Width], "right_y", ">> 1", "a neighbour is a response without its sign", Hole(UNUSED)),
    (
        "hoverlock_core",
        &[Kind::Width],
        "extractor_frames",
        "",
        "no run has 2^31 frames: 4.5 years at 15 a second",
        Hole(UNUSED),
    ),
    (
        "sequencer",
        &[Kind::Stuck, Kind::Width],
        "new_width",
        "",
        "wider frames are refused, so none has the highest bit",
        Hole(UNUSED),
    ),
];

/// The folder of the committed files.
pub fn verilog() -> &'static Path {
    static FOLDER: LazyLock<std::path::PathBuf> =
        LazyLock::new(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../rtl/verilog"));
    &FOLDER
}

/// The module that a fault is in: the instance's, where it is in what an instance is connected to.
fn module(mutant: &Mutant) -> &str {
    mutant.at.as_ref().unwrap_or(&mutant.module)
}

/// Whether a row is about a fault.
fn fits(&(place, kinds, original, fault, ..): &Harmless, mutant: &Mutant) -> bool {
    let of = |place: &str, name: &str| place.strip_suffix('*').map_or(name == place, |family| name.starts_with(family));
    let at = module(mutant);
    place.split_once('/').map_or_else(|| of(place, at), |(outer, inner)| of(outer, &mutant.module) && of(inner, at))
        && kinds.contains(&mutant.kind)
        && mutant.original.contains(original)
        && mutant.fault.contains(fault)
}

/// Why a fault of a design other than the default is harmless: as the same fault of the default design is, for which
/// the claim is proved.
pub fn reason_in_another_design(sources: &[Source], mutant: &Mutant) -> Option<String> {
    let row = HARMLESS.iter().chain(ELSEWHERE).find(|row| fits(row, mutant));
    let in_words = row.map(|(.., words, shown)| match shown {
        By(claim) | Later(claim) => {
            format!("{words}: claim `{}` shows it of the default design", claim.replace('*', module(mutant)))
        }
        Hole(number) => format!("{words}: hole {number}"),
    });
    in_words.or_else(|| equivalent(sources, mutant))
}

/// Why a fault is harmless, after a proof of it; `None` where nothing shows it.
pub fn reason(sources: &[Source], mutant: &Mutant) -> Option<String> {
    let (words, shown) = match HARMLESS.iter().find(|row| fits(row, mutant)) {
        Some((.., words, shown)) => (words, shown),
        None => return equivalent(sources, mutant),
    };
    let (name, and) = match shown {
        By(name) => (name, String::new()),
        Later(name) => (name, format!(", hole {FIRST_SAMPLE}")),
        Hole(number) => return Some(format!("{words}: hole {number}")),
    };
    let name = name.replace('*', module(mutant));
    let claim = shipped::claims().ok()?.into_iter().find(|claim| claim.name == name)?;
    holds(&claim, sources, mutant)
        .then(|| format!("{words}: claim `{name}` holds with it{and}"))
        .or_else(|| equivalent(sources, mutant))
}

fn equivalent(sources: &[Source], mutant: &Mutant) -> Option<String> {
    is_proved_equivalent(sources, mutant).then(|| "Yosys proves both equivalent".to_owned())
}

/// Whether a claim is proved with the fault. Where the fault is in the reset of an instance, and the claim is about the
/// instance and any state that a reset may leave, its proof is that without the fault.
fn holds(claim: &Claim, sources: &[Source], mutant: &Mutant) -> bool {
    let out = tempfile::tempdir().unwrap();
    let place =
        Place { sources: verilog(), out: out.path(), limit: Duration::from_secs(600), solver: Solver::default() };
    let file = format!("{}.v", mutant.file);
    let proved = if claim.sources.contains(&file) {
        let Some(source) = sources.iter().find(|source| source.module == mutant.file) else { return false };
        holds_with(claim, &FaultySource { file, text: by_hand(source, mutant) }, &place)
    } else {
        let instance = mutant.at.as_ref().is_some_and(|at| claim.sources.contains(&format!("{}.v", plain(at))));
        if !instance || mutant.kind != Kind::Reset {
            return false;
        }
        run(claim, Task::Proof, &place)
    };
    proved.is_ok_and(|outcome| outcome.status == Status::Proved)
}
