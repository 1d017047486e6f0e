//! The claims as one theorem: its steps, the rules that the integrator keeps, and what guarantees each assumption.
//!
//! Assume-guarantee reasoning is sound if no claim rests on itself. So what the assumptions refer to must exist, and
//! the references must not form a circle.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;

use crate::claim::{Assumption, Claim};
use crate::rounding::Subject;

/// A condition that the integrator of the component keeps.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rule {
    /// Name, unique among the rules.
    pub name: String,
    /// The condition in words.
    pub text: String,
}

/// A step of the theorem: what holds, and by which claims.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// Name of the step.
    pub name: String,
    /// What holds, in words.
    pub text: String,
    /// Names of the claims.
    pub by: Vec<String>,
    /// Names of the rules that it needs.
    #[serde(default)]
    pub rules: Vec<String>,
    /// Numbers of the holes in formal/README.md that are left in it.
    #[serde(default)]
    pub open: Vec<u32>,
}

/// The theorem about the component.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Composition {
    /// The theorem in words.
    pub statement: String,
    /// The rules that the integrator keeps.
    #[serde(rename = "rule")]
    pub rules: Vec<Rule>,
    /// The steps.
    #[serde(rename = "step")]
    pub steps: Vec<Step>,
}

/// What the theorem knows of a claim: its assumptions, and the text with its assertions, which a claim about numbers
/// has not.
struct Part<'a> {
    assumed: Vec<Assumption>,
    properties: Option<&'a str>,
}

/// Returns all claims by name.
fn parts(claims: &[Claim]) -> BTreeMap<&str, Part<'_>> {
    let of_claims = claims.iter().map(|claim| {
        let part = Part { assumed: claim.assumed.clone(), properties: Some(&claim.properties) };
        (claim.name.as_str(), part)
    });
    let of_subjects = Subject::ALL.iter().map(|of| (of.name(), Part { assumed: of.assumed(), properties: None }));
    of_claims.chain(of_subjects).collect()
}

/// Returns the claim that an assertion `claim.label` belongs to.
fn claim_of(assertion: &str) -> &str {
    assertion.split('.').next().unwrap_or_default()
}

impl Composition {
    /// The theorem about the emitted Verilog.
    ///
    /// # Errors
    /// If `composition.toml` is invalid.
    pub fn shipped() -> Result<Self, toml::de::Error> {
        toml::from_str(include_str!("../composition.toml"))
    }

    /// Returns what is wrong with the theorem, each in a line: an assertion, a claim, a rule or a hole that does not
    /// exist, an assumption that nothing guarantees, claims that rest on each other, and claims and rules without use.
    /// `claims` are those of the default design, `holes` the numbers of the holes that formal/README.md has.
    pub fn gaps(&self, claims: &[Claim], holes: &BTreeSet<u32>) -> Vec<String> {
        let parts = parts(claims);
        let mut gaps = Vec::new();
        let mut used: BTreeSet<&str> = self.steps.iter().flat_map(|step| &step.rules).map(String::as_str).collect();
        let mut open: Vec<(&str, u32)> = Vec::new();
        for step in &self.steps {
            open.extend(step.open.iter().map(|hole| (step.name.as_str(), *hole)));
            let unknown = step.by.iter().filter(|claim| !parts.contains_key(claim.as_str()));
            gaps.extend(unknown.map(|claim| format!("step {}: no claim {claim}", step.name)));
        }
        for name in parts.keys() {
            if !self.steps.iter().any(|step| step.by.iter().any(|claim| claim == name)) {
                gaps.push(format!("no step rests on claim {name}"));
            }
        }
        let assumptions: Vec<(&str, &Assumption)> =
            parts.iter().flat_map(|(name, part)| part.assumed.iter().map(|assumed| (*name, assumed))).collect();
        for (name, assumed) in assumptions {
            let Assumption { text, by, rule, hole } = assumed;
            if by.is_empty() && rule.is_none() && hole.is_none() {
                gaps.push(format!("claim {name}: nothing guarantees “{text}”"));
            }
            used.extend(rule.as_deref());
            open.extend(hole.map(|hole| (name, hole)));
            let missing = by.iter().filter(|assertion| !is_stated(&parts, assertion));
            gaps.extend(missing.map(|assertion| format!("claim {name}: no assertion {assertion}")));
        }
        for rule in &used {
            if !self.rules.iter().any(|known| known.name == *rule) {
                gaps.push(format!("no rule {rule}"));
            }
        }
        let unused = self.rules.iter().filter(|rule| !used.contains(rule.name.as_str()));
        gaps.extend(unused.map(|rule| format!("nothing needs rule {}", rule.name)));
        let no_hole = open.iter().filter(|(_, hole)| !holes.contains(hole));
        gaps.extend(no_hole.map(|(name, hole)| format!("{name}: no hole {hole}")));
        gaps.extend(circle(&parts).map(|names| format!("claims that rest on each other: {}", names.join(", "))));
        gaps
    }

    /// Returns the theorem as Markdown: statement, rules, and steps with the claims they rest on.
    pub fn markdown(&self) -> String {
        let list = |names: &[String]| names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        let mut text = format!("{}\n\nRules that the integrator keeps:\n\n", self.statement);
        for Rule { name, text: rule } in &self.rules {
            text += &format!("- **`{name}`** {rule}\n");
        }
        text += "\n| step | what holds | by | rules | holes left |\n|---|---|---|---|---|\n";
        for Step { name, text: what, by, rules, open } in &self.steps {
            let open: Vec<String> = open.iter().map(u32::to_string).collect();
            text += &format!("| {name} | {what} | {} | {} | {} |\n", list(by), list(rules), open.join(", "));
        }
        text + "\nHoles are those of [README.md](README.md#proof-holes). The assumptions of the claims, and what \
                guarantees each, stand with their statements above.\n"
    }
}

/// Returns an assumption with what guarantees it, in one line.
pub fn assumption_line(assumed: &Assumption) -> String {
    let by = assumed.by.iter().map(|assertion| format!("`{assertion}`"));
    let rule = assumed.rule.iter().map(|rule| format!("rule `{rule}`"));
    let hole = assumed.hole.iter().map(|hole| format!("hole {hole}"));
    let guarantees: Vec<String> = by.chain(rule).chain(hole).collect();
    format!("{}: {}", assumed.text, guarantees.join(", "))
}

/// Returns `true` if an assertion `claim.label` is in the wrapper of the claim, by itself or as an instance of a module
/// of properties, or if it names a claim about numbers.
fn is_stated(parts: &BTreeMap<&str, Part>, assertion: &str) -> bool {
    match (assertion.split_once('.'), parts.get(claim_of(assertion))) {
        (None, Some(part)) => part.properties.is_none(),
        (Some((_, label)), Some(Part { properties: Some(text), .. })) => {
            !label.is_empty()
                && [format!(" {label}: assert ("), format!(") {label} (\n")].iter().any(|of| text.contains(of))
        }
        _ => false,
    }
}

/// Returns the claims of a circle of assumptions, if there is one.
fn circle<'a>(parts: &BTreeMap<&'a str, Part>) -> Option<Vec<&'a str>> {
    let mut left: BTreeSet<&str> = parts.keys().copied().collect();
    loop {
        let rests = |name: &str| parts[name].assumed.iter().flat_map(|of| &of.by).any(|by| left.contains(claim_of(by)));
        let free: Vec<&str> = left.iter().copied().filter(|name| !rests(name)).collect();
        if free.is_empty() {
            break;
        }
        free.iter().for_each(|name| {
            left.remove(name);
        });
    }
    if left.is_empty() { None } else { Some(left.into_iter().collect()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shipped;

    /// The numbers of the holes that formal/README.md lists.
    fn holes() -> BTreeSet<u32> {
        let text = include_str!("../README.md").split("## Proof holes").nth(1).unwrap_or_default();
        let number = |line: &str| line.split_once(". **").and_then(|(number, _)| number.parse().ok());
        text.lines().filter_map(number).collect()
    }

    #[test]
    fn each_assumption_of_the_shipped_claims_is_guaranteed() {
        let gaps = Composition::shipped().unwrap().gaps(&shipped::claims().unwrap(), &holes());
        assert!(gaps.is_empty(), "{}", gaps.join("\n"));
    }

    #[test]
    fn an_assumption_in_a_wrapper_is_listed() {
        for claim in shipped::claims().unwrap() {
            let assumes = claim.properties.lines().filter(|line| line.contains("assume (") && !line.contains("reset"));
            let beyond_reset = assumes.count() > 0;
            // These compare two copies from equal states, or assume the state in which they begin.
            let is_of_wrapper = ["row_look_ahead_border", "unset_registers"].contains(&claim.name.as_str())
                || claim.name.starts_with("ring_taps");
            assert!(!beyond_reset || is_of_wrapper || !claim.assumed.is_empty(), "{}", claim.name);
        }
    }

    #[test]
    fn gaps_are_named() {
        let claims = || shipped::claims().unwrap();
        let of = |change: &dyn Fn(&mut Composition, &mut Vec<Claim>)| {
            let (mut theorem, mut claims) = (Composition::shipped().unwrap(), claims());
            change(&mut theorem, &mut claims);
            theorem.gaps(&claims, &holes()).join("\n")
        };
        let assume = |claims: &mut Vec<Claim>, name: &str, assumed: Assumption| {
            claims.iter_mut().find(|claim| claim.name == name).unwrap().assumed.push(assumed);
        };
        let bare = Assumption { text: "x".into(), ..Assumption::default() };
        assert_eq!(of(&|_, claims| assume(claims, "csr", bare.clone())), "claim csr: nothing guarantees “x”");
        let by = |assertion: &str| Assumption { by: vec![assertion.into()], ..bare.clone() };
        assert_eq!(of(&|_, claims| assume(claims, "csr", by("top.nothing"))), "claim csr: no assertion top.nothing");
        let circle = of(&|_, claims| assume(claims, "csr", by("sequencer.size")));
        assert!(
            circle.contains("rest on each other") && circle.contains("csr, ") && circle.contains("sequencer"),
            "{circle}"
        );
        let hole = Assumption { hole: Some(99), ..bare.clone() };
        assert_eq!(of(&|_, claims| assume(claims, "csr", hole.clone())), "csr: no hole 99");
        let rule = Assumption { rule: Some("luck".into()), ..bare.clone() };
        assert_eq!(of(&|_, claims| assume(claims, "csr", rule.clone())), "no rule luck");
        assert_eq!(
            of(&|theorem, _| theorem.steps.retain(|step| step.name != "connections")),
            "no step rests on claim wiring"
        );
        let step = of(&|theorem, _| theorem.steps[0].by.push("magic".into()));
        assert_eq!(step, "step ports: no claim magic");
        assert_eq!(of(&|theorem, _| theorem.steps[0].rules.retain(|rule| rule != "clock")), "nothing needs rule clock");
    }
}
