//! Many faults on several threads.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use crate::draw::Fault;

/// Runs the bench once for each fault, on `threads` threads, and returns the outcomes in the order of the faults.
/// `done` is called with the number of runs that have ended.
///
/// # Errors
/// The first error of the bench; the other runs are given up.
pub fn campaign<T: Send, E: Send>(
    faults: &[Fault],
    threads: usize,
    bench: impl Fn(&Fault) -> Result<T, E> + Sync,
    done: impl Fn(usize) + Sync,
) -> Result<Vec<T>, E> {
    let (next, ended, failed) = (AtomicUsize::new(0), AtomicUsize::new(0), AtomicBool::new(false));
    let outcomes: Mutex<Vec<(usize, Result<T, E>)>> = Mutex::default();
    let work = || {
        let mut own = Vec::new();
        while !failed.load(Ordering::Relaxed) {
            let at = next.fetch_add(1, Ordering::Relaxed);
            let Some(fault) = faults.get(at) else { break };
            let outcome = bench(fault);
            failed.fetch_or(outcome.is_err(), Ordering::Relaxed);
            own.push((at, outcome));
            done(ended.fetch_add(1, Ordering::Relaxed) + 1);
        }
        // A thread that panicked ends the scope, which passes the panic on.
        if let Ok(mut all) = outcomes.lock() {
            all.append(&mut own);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            scope.spawn(work);
        }
    });
    let mut outcomes = outcomes.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    outcomes.sort_by_key(|(at, _)| *at);
    outcomes.into_iter().map(|(_, outcome)| outcome).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::class::Class;
    use crate::draw::Kind;
    use crate::state::Bit;

    fn faults(count: u64) -> Vec<Fault> {
        let bit = Bit { register: 0, word: 0, bit: 0 };
        (0..count).map(|cycle| Fault { bit, cycle, kind: Kind::Seu }).collect()
    }

    #[test]
    fn outcomes_are_in_the_order_of_the_faults() {
        let most = AtomicUsize::new(0);
        let class =
            |fault: &Fault| Ok::<_, ()>(if fault.cycle.is_multiple_of(3) { Class::Silent } else { Class::Masked });
        let found = campaign(&faults(100), 3, class, |done| {
            most.fetch_max(done, Ordering::Relaxed);
        });
        let found = found.unwrap();
        assert_eq!(found.len(), 100);
        assert!(found.iter().enumerate().all(|(i, class)| i.is_multiple_of(3) == (*class == Class::Silent)));
        assert_eq!(most.into_inner(), 100);
    }

    #[test]
    fn an_error_ends_the_campaign() {
        let runs = AtomicUsize::new(0);
        let bench = |fault: &Fault| {
            runs.fetch_add(1, Ordering::Relaxed);
            if fault.cycle == 5 { Err("no model") } else { Ok(Class::Masked) }
        };
        assert_eq!(campaign(&faults(10_000), 2, bench, |_| ()), Err("no model"));
        assert!(runs.into_inner() < 10_000);
    }
}
