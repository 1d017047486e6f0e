//! The page, its numbers as JSON, each drawing as a file, and the pictures that its commands read.

use std::collections::BTreeMap;

use hoverlock_reports::page::{PageError, SCRIPT, STYLE, environment, value};
use hoverlock_reports::provenance::COMMIT;
use minijinja::context;
use serde::Serialize;

use crate::Item;

/// File name of the page.
pub const PAGE: &str = "index.html";
/// File name of its numbers.
pub const NUMBERS: &str = "paper.json";
/// The names of all files of the page: what [`all_files`] returns, known before the items are.
pub const FILES: [&str; 26] = [
    PAGE,
    NUMBERS,
    "field_1.png",
    "field_1_above.png",
    "field_2.png",
    "field_2_above.png",
    "field_2_fog.png",
    "figure_1.svg",
    "figure_10_formulas_1_to_8.svg",
    "figure_11_formulas_9_to_11.svg",
    "figure_12.svg",
    "figure_13.svg",
    "figure_14.2.svg",
    "figure_14.svg",
    "figure_15.svg",
    "figure_3.svg",
    "figure_4_formula_1.svg",
    "figure_5.2.svg",
    "figure_5.svg",
    "figure_6.2.svg",
    "figure_6.svg",
    "figure_8.svg",
    "figure_9.2.svg",
    "figure_9.svg",
    "town_1_above.png",
    "town_2_above.png",
];

const TEMPLATE: &str = include_str!("../templates/paper.html");

/// The object of `--json`, and of `paper.json`.
#[derive(Debug, Serialize)]
pub struct Numbers<'a> {
    /// Commit of the sources.
    pub commit: &'static str,
    /// The items in the order of the description.
    pub items: &'a [Item],
}

impl<'a> Numbers<'a> {
    /// Describes the items.
    pub fn of(items: &'a [Item]) -> Self {
        Self { commit: COMMIT, items }
    }
}

/// Renders the items as one HTML page.
///
/// # Errors
/// The template fails, which is a defect of this program.
pub fn html(items: &[Item]) -> Result<String, PageError> {
    let count = |holds: bool| items.iter().filter(|item| item.holds == Some(holds)).count();
    let rows: Vec<_> =
        items.iter().map(|item| context! { item => value(item), drawings => value(&item.drawings) }).collect();
    let mut environment = environment();
    environment.add_template("paper.html", TEMPLATE)?;
    Ok(environment.get_template("paper.html")?.render(context! {
        style => STYLE,
        script => SCRIPT,
        commit => COMMIT,
        rows => rows,
        held => count(true),
        failed => count(false),
        shown => items.len() - count(true) - count(false),
    })?)
}

/// Why the files of the page were not made.
#[derive(Debug, thiserror::Error)]
pub enum FilesError {
    /// The page could not be rendered.
    #[error(transparent)]
    Page(#[from] PageError),
    /// The numbers could not be written as JSON.
    #[error("the page cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
}

/// Returns all files by name: the page, its numbers, each drawing, and the pictures that the commands read.
///
/// # Errors
/// The page or its numbers cannot be made.
pub fn all_files(items: &[Item]) -> Result<BTreeMap<String, Vec<u8>>, FilesError> {
    let numbers = serde_json::to_string_pretty(&Numbers::of(items))?;
    let mut all = BTreeMap::from([(PAGE.into(), html(items)?.into_bytes()), (NUMBERS.into(), numbers.into_bytes())]);
    all.extend(drawings(items).into_iter().map(|(name, svg)| (name, svg.into_bytes())));
    // Items share pictures.
    all.extend(items.iter().flat_map(|item| item.inputs.iter().cloned()));
    Ok(all)
}

/// Returns each drawing as a complete SVG file on white, with its name: `figure_4_formula_1.svg`, and `.2.svg` for a
/// second one.
fn drawings(items: &[Item]) -> Vec<(String, String)> {
    let mut files = Vec::new();
    for item in items {
        let words: Vec<&str> =
            item.number.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty()).collect();
        for (i, drawing) in item.drawings.iter().enumerate() {
            let which = if i == 0 { String::new() } else { format!(".{}", i + 1) };
            let (head, rest) = drawing.split_once('>').unwrap_or((drawing, ""));
            let svg = format!(
                "{head} xmlns=\"http://www.w3.org/2000/svg\"><rect width=\"100%\" height=\"100%\" \
                 fill=\"white\"/>{rest}"
            );
            files.push((format!("{}{which}.svg", words.join("_")), svg));
        }
    }
    files
}

#[cfg(test)]
mod tests {
    use super::*;

    fn item(holds: Option<bool>) -> Item {
        Item {
            number: "figure 4, formula (1)",
            title: "A < B",
            stated: "It holds.",
            found: "3 of 4 & more".into(),
            holds,
            evidence: "hoverlock paper",
            drawings: vec!["<svg viewBox=\"0 0 1 1\"></svg>".into(); 2],
            ..Item::default()
        }
    }

    #[test]
    fn the_page_has_each_item_and_its_verdict() {
        let page = html(&[item(Some(true)), item(Some(false)), item(None)]).unwrap();
        assert!(page.contains("A &lt; B") && page.contains("3 of 4 &amp; more"));
        let verdicts = ["holds</td>", "does not hold</td>", "shown</td>"];
        assert!(verdicts.iter().all(|verdict| page.contains(verdict)), "{page}");
        assert_eq!(page.matches("<svg viewBox").count(), 6);
    }

    #[test]
    fn drawings_are_files_of_their_own() {
        let names: Vec<String> = drawings(&[item(None)]).into_iter().map(|file| file.0).collect();
        assert_eq!(names, ["figure_4_formula_1.svg", "figure_4_formula_1.2.svg"]);
    }
}
