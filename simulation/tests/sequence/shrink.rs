//! A failing sequence made shorter and plainer, as long as it still fails.

use super::{Before, Content, Fault, Sequence, Step};

/// Changes that make a step plainer.
const PLAINER: [fn(&mut Step); 14] = [
    |step| step.reset = None,
    |step| step.before = Before::Nothing,
    |step| step.fault = Fault::None,
    |step| step.closed = 0,
    |step| step.pauses = [0, 0],
    |step| step.pauses[0] = 0,
    |step| step.pauses[1] = 0,
    |step| step.scribbles = false,
    |step| step.racing = None,
    |step| step.automatic = false,
    |step| step.coefficients = None,
    |step| step.gap = 0,
    |step| step.height = 64,
    |step| step.content = Content::Noise,
];

/// Returns the plainest sequence that still `fails`, of those tried.
pub fn shrunk(sequence: &Sequence, trials: usize, mut fails: impl FnMut(&Sequence) -> bool) -> Sequence {
    let mut best = sequence.clone();
    let mut left = trials;
    let mut keep = |candidate: Sequence, best: &mut Sequence| {
        let candidate = candidate.agreed();
        if left == 0 || candidate == *best {
            return false;
        }
        left -= 1;
        let found = fails(&candidate);
        if found {
            *best = candidate;
        }
        found
    };
    // Whole frames first: what comes after the failure, then one after the other.
    while best.frames.len() > 1 {
        let mut shorter = best.clone();
        shorter.frames.pop();
        if !keep(shorter, &mut best) {
            break;
        }
    }
    let mut at = 0;
    while at < best.frames.len() && best.frames.len() > 1 {
        let mut shorter = best.clone();
        shorter.frames.remove(at);
        if !keep(shorter, &mut best) {
            at += 1;
        }
    }
    for at in 0..best.frames.len() {
        for change in PLAINER {
            let mut plainer = best.clone();
            change(&mut plainer.frames[at]);
            keep(plainer, &mut best);
        }
    }
    best
}
