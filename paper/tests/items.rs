//! The whole description, regenerated: each item is there, and says what was measured independently.

use hoverlock_paper::{Item, items, page};

fn item<'a>(items: &'a [Item], number: &str) -> &'a Item {
    items.iter().find(|item| item.number.split(", ").any(|part| part == number)).unwrap()
}

#[test]
fn each_figure_and_claim_is_regenerated() {
    let items = items(|_, _| {}).unwrap();
    for figure in 1..=15 {
        assert!(!item(&items, &format!("figure {figure}")).found.is_empty());
    }
    let claims = items.iter().map(|item| (item.number, item.holds)).filter(|(_, holds)| holds.is_some());
    let expected = [
        ("figure 2, table 1", true),
        ("figure 4, formula (1)", true),
        // The mean of the formula is 0.86 m: 1 m is a mean, not a bound.
        ("claim 1", false),
        ("figure 7", true),
        ("figure 9", true),
        ("figure 10, formulas (1) to (8)", true),
        ("figure 11, formulas (9) to (11)", true),
        ("figure 15", true),
        ("claim 2", true),
    ];
    let found: Vec<(&str, bool)> = claims.map(|(number, holds)| (number, holds.unwrap())).collect();
    assert_eq!(found, expected, "{:#?}", items.iter().map(|item| &item.found).collect::<Vec<_>>());
    // The printed form of the functional must choose the worse hypothesis: that is what the figure is about.
    assert!(item(&items, "figure 11").found.contains("as printed 0,"), "{}", item(&items, "figure 11").found);
    assert!(
        items
            .iter()
            .flat_map(|item| &item.drawings)
            .all(|svg| svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"))
    );
    // The command asks by these names, before the items are there, whether it may write.
    let written: Vec<String> = page::all_files(&items).unwrap().into_keys().collect();
    let mut named = page::FILES;
    named.sort_unstable();
    assert_eq!(written, named);
}
