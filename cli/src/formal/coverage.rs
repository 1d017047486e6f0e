//! `hoverlock formal --coverage`: the share of mutations drawn by chance that a claim's proof detects.

use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use hoverlock_formal::claim::{Claim, Hole};
use hoverlock_formal::coverage::{Campaign, Class, MAX_MUTATIONS, Mutation};
use hoverlock_formal::engine::Solver;
use hoverlock_formal::prove::Place;
use hoverlock_formal::rounding::Subject;
use hoverlock_formal::shipped;
use serde::Serialize;

use super::{Args, NotStated, all, design, earlier, nothing_left, own_claim, rows_of, shape, sources, take_not_stated};
use crate::Verdict;
use crate::output::{print, print_json, quoted, say, shown, verdict, write_file};

/// Head of the section of the results that lists coverage; it is the last one.
const SECTION: &str = "\n## Coverage by mutations drawn by chance\n";

/// How mutations are drawn.
#[derive(clap::Args)]
pub struct Drawing {
    /// Mutations of each claim, for --coverage
    #[arg(long, value_name = "N", default_value = "200", requires = "coverage",
        value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_MUTATIONS)))]
    mutations: u32,
    /// Seed of the drawing
    #[arg(long, value_name = "S", default_value = "1", requires = "coverage",
        value_parser = clap::value_parser!(u32).range(0..=0x3fff_ffff))]
    seed: u32,
    /// Classify only the mutation of this number
    #[arg(long, value_name = "K", requires = "coverage")]
    only: Option<usize>,
}

/// The JSON object of `--json`.
#[derive(Serialize)]
struct Report {
    claims: Vec<Score>,
    /// Number of survivors and undecided mutations that no hole lists.
    failed: usize,
}

/// The result of a claim.
#[derive(Serialize)]
struct Score {
    claim: String,
    seed: u32,
    drawn: usize,
    harmless: usize,
    /// Mutations with which the proof fails.
    killed: usize,
    /// Of these, mutations with which only the induction fails.
    unproved: usize,
    survivors: usize,
    undecided: usize,
    /// Survivors and undecided mutations that are in a hole.
    in_holes: usize,
    seconds: f64,
    results: Vec<Classified>,
    /// Holes that list no survivor.
    empty_holes: Vec<u32>,
}

/// A mutation with its class.
#[derive(Serialize)]
struct Classified {
    #[serde(flatten)]
    mutation: Mutation,
    class: Class,
    /// Number of the hole that lists it.
    hole: Option<u32>,
    seconds: f64,
}

impl Classified {
    fn is_open(&self) -> bool {
        matches!(self.class, Class::Survivor | Class::Undecided)
    }
}

pub fn run(args: &Args) -> Result<Verdict> {
    let mut claims = match &args.properties {
        Some(properties) => only(own_claim(args, properties)?, &args.coverage)?,
        None => named(args)?,
    };
    let sources = sources(args)?;
    let not_stated = take_not_stated(args, &mut claims, &sources)?;
    if claims.is_empty() {
        bail!(nothing_left(&not_stated));
    }
    for NotStated { name, reason } in &not_stated {
        say(&format!("{name}: not stated for this Verilog: {reason}"));
    }
    let limit = Duration::from_secs_f64(args.limit);
    let place = Place { sources: &sources, out: &args.out, limit, solver: Solver::Yices };
    let mut scores = Vec::new();
    for claim in &claims {
        let score = score(claim, &args.drawing, &place)?;
        if !args.json {
            print(&score.lines(&repeat(args)))?;
        }
        // A later claim that takes too long loses nothing.
        if let Some(file) = &args.table {
            enter(file, &score)?;
        }
        scores.push(score);
    }
    let failed: usize = scores.iter().map(Score::failed).sum();
    if args.json {
        print_json(&Report { claims: scores, failed })?;
    } else {
        let sum = |of: fn(&Score) -> usize| scores.iter().map(of).sum::<usize>();
        let summary = format!(
            "{} mutations: {} harmless, {} killed, {} survive, {} undecided; {} in holes",
            sum(|score| score.drawn),
            sum(|score| score.harmless),
            sum(|score| score.killed),
            sum(|score| score.survivors),
            sum(|score| score.undecided),
            sum(|score| score.in_holes),
        );
        print(&(verdict(failed == 0, &summary) + "\n"))?;
    }
    Ok((failed == 0).into())
}

/// Returns the command of this run, without the claim.
fn repeat(args: &Args) -> String {
    let Drawing { mutations, seed, .. } = args.drawing;
    let mut text = "hoverlock formal".to_owned();
    if let Some(properties) = &args.properties {
        let sources: String = args.source.iter().map(|file| format!(" {}", shown(file))).collect();
        text += &format!(" --source{sources} --properties {} --depth {}", shown(properties), args.depth);
        text += if args.bounded { " --bounded" } else { "" };
    } else if let Some(folder) = &args.rtl {
        text += &format!(" --rtl {}", shown(folder));
    }
    if let Some(design) = &args.design {
        text += &format!(" --design {}", quoted(Path::new(design)));
    }
    format!("{text} --mutations {mutations} --seed {seed}")
}

/// Returns the claim if `names` are its name.
fn only(claim: Claim, names: &[String]) -> Result<Vec<Claim>> {
    match names.iter().find(|name| **name != claim.name && *name != "all") {
        Some(name) => bail!("--coverage {name}: no such claim; the file of --properties makes it {}", claim.name),
        None => Ok(vec![claim]),
    }
}

/// Returns the claims of these names.
fn named(args: &Args) -> Result<Vec<Claim>> {
    let (names, mut claims) = (&args.coverage, shipped::claims_of(&shape(&design(args)?)?)?);
    for name in names {
        if Subject::ALL.iter().any(|subject| subject.name() == name) {
            bail!("--coverage {name}: this claim is about the numbers of a design; it has no module to mutate");
        }
        if name != "all" && !claims.iter().any(|claim| claim.name == *name) {
            let known: Vec<&str> = claims.iter().map(|claim| claim.name.as_str()).collect();
            bail!("--coverage {name}: no such claim; they are all, {}", known.join(", "));
        }
    }
    claims.retain(|claim| names.iter().any(|name| name == "all" || *name == claim.name));
    Ok(claims)
}

/// Draws and classifies the mutations of a claim.
fn score(claim: &Claim, drawing: &Drawing, place: &Place) -> Result<Score> {
    let start = Instant::now();
    let campaign = Campaign::new(claim, place, drawing.mutations, drawing.seed)?;
    let asked = |mutation: &&Mutation| drawing.only.is_none_or(|only| only == mutation.number);
    let mutations: Vec<&Mutation> = campaign.mutations().iter().filter(asked).collect();
    if let (Some(only), true) = (drawing.only, mutations.is_empty()) {
        bail!("--only {only}: {} has mutations 1 to {}", claim.name, campaign.mutations().len());
    }
    let classify = |mutation: &&Mutation| -> Result<Classified> {
        let (class, seconds) = campaign.classify(mutation)?;
        let hole = claim.holes.iter().find(|hole| hole.matches(mutation)).map(|hole| hole.number);
        let mutation = (*mutation).clone();
        Ok(Classified { mutation, class, hole, seconds })
    };
    let results = all(&mutations, classify, |done| format!("{} {}", claim.name, done.mutation.number))?;
    let count = |of: &dyn Fn(&Classified) -> bool| results.iter().filter(|result| of(result)).count();
    let is_empty = |hole: &&Hole| !results.iter().any(|result| result.is_open() && result.hole == Some(hole.number));
    // A hole that is empty in another drawing may still be one.
    let is_committed = drawing.only.is_none() && drawing.is_default();
    let empty_holes = claim.holes.iter().filter(|_| is_committed).filter(is_empty).map(|hole| hole.number).collect();
    Ok(Score {
        claim: claim.name.clone(),
        seed: drawing.seed,
        drawn: results.len(),
        harmless: count(&|result| result.class == Class::Harmless),
        killed: count(&|result| result.class.is_killed()),
        unproved: count(&|result| result.class == Class::Unproved),
        survivors: count(&|result| result.class == Class::Survivor),
        undecided: count(&|result| result.class == Class::Undecided),
        in_holes: count(&|result| result.is_open() && result.hole.is_some()),
        seconds: start.elapsed().as_secs_f64(),
        results,
        empty_holes,
    })
}

impl Drawing {
    fn is_default(&self) -> bool {
        (self.mutations, self.seed) == (200, 1)
    }
}

impl Score {
    fn failed(&self) -> usize {
        self.survivors + self.undecided - self.in_holes + self.empty_holes.len()
    }

    /// Describes the result in one line, and each mutation that was not detected in two.
    fn lines(&self, repeat: &str) -> String {
        let Self { claim, drawn, harmless, killed, survivors, undecided, in_holes, seconds, .. } = self;
        let mut text = format!(
            "{claim:<22} {drawn:4} drawn {harmless:4} harmless {killed:4} killed {survivors:4} survive {undecided:4} \
             undecided {in_holes:4} in holes {seconds:7.1} s\n"
        );
        // Where not even the claim is proved in time, its mutations say nothing one by one.
        if undecided == drawn {
            return text + "  no mutation was decided: raise --limit\n";
        }
        for Classified { mutation, class, hole, .. } in self.results.iter().filter(|result| result.is_open()) {
            let Mutation { number, mode, module, port, wire, file, line, text: source, .. } = mutation;
            let class = format!("{class:?}").to_lowercase();
            let hole = hole.map_or(String::new(), |hole| format!(" (hole {hole})"));
            let wire = wire.as_ref().map_or(String::new(), |wire| format!(", wire {wire}"));
            text += &format!(
                "  {class} {number}{hole}: {mode} of {module}, port {port}{wire}\n    {file}:{line}: {source}\n    \
                 {repeat} --coverage {claim} --only {number}\n"
            );
        }
        for hole in &self.empty_holes {
            text += &format!("  hole {hole} lists no survivor: remove it from the claim's file\n");
        }
        text
    }
}

/// Returns the section about coverage of results, which is the last one; empty if they have none.
pub fn section_of(results: &str) -> &str {
    results.find(SECTION).map_or("", |at| &results[at..])
}

/// Enters a score into the section about coverage of a file of results, in place of an earlier one of its claim.
fn enter(file: &Path, score: &Score) -> Result<()> {
    let text = earlier(file)?;
    let section = section_of(&text);
    let before = &text[..text.len() - section.len()];
    write_file(file, format!("{before}{}", table(section, score)?).as_bytes())
}

/// Returns the section with this score in place of an earlier one of its claim, and all holes of claims.
fn table(earlier: &str, score: &Score) -> Result<String> {
    let mut rows = rows_of(earlier);
    let Score { claim, seed, drawn, harmless, killed, unproved, survivors, undecided, in_holes, seconds, .. } = score;
    rows.insert(
        claim.clone(),
        format!(
            "| `{claim}` | {seed} | {drawn} | {harmless} | {killed} | {unproved} | {survivors} | {undecided} | \
             {in_holes} | {seconds:.0} |"
        ),
    );
    let claims = shipped::claims()?;
    let rows: Vec<&str> = claims.iter().filter_map(|claim| Some(rows.get(&claim.name)?.as_str())).collect();
    let heads = [
        "claim",
        "seed",
        "drawn",
        "harmless",
        "killed",
        "by induction only",
        "survivors",
        "undecided",
        "in holes",
        "time, s",
    ];
    let holes: String = claims
        .iter()
        .flat_map(|claim| claim.holes.iter().map(|Hole { number, reason, .. }| (&claim.name, number, reason)))
        .map(|(claim, number, reason)| format!("- `{claim}`, {number}: {reason}\n"))
        .collect();
    Ok(format!(
        "{SECTION}\nWritten by `hoverlock formal --coverage all --table formal/RESULTS.md`.\n\n| {} |\n|{}\n{}\n\n\
         Holes of the claims, with their numbers:\n\n{holes}",
        heads.join(" | "),
        "---|".repeat(heads.len()),
        rows.join("\n")
    ))
}
