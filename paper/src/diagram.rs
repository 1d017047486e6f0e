//! Diagrams of boxes in a row, with an arrow from each to the next.

use std::fmt::Write as _;

use minijinja::HtmlEscape;

/// Width and height of a box, and the length of an arrow, in units of the drawing.
const BOX: [usize; 2] = [190, 116];
const ARROW: usize = 120;
/// Space around the drawing.
const MARGIN: usize = 12;

/// A box: its name, and lines of what is in it.
pub struct Block<'a> {
    pub name: &'a str,
    pub content: Vec<String>,
}

/// Draws boxes from left to right. `flows` are the words on the arrows between them, at most two lines each.
pub fn row(title: &str, blocks: &[Block<'_>], flows: &[[&str; 2]]) -> String {
    let pitch = BOX[0] + ARROW;
    let width = 2 * MARGIN + blocks.len() * pitch - ARROW;
    let height = 2 * MARGIN + BOX[1];
    let mut svg = format!(
        "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{}\" font-size=\"14\">",
        HtmlEscape(title)
    );
    for (i, block) in blocks.iter().enumerate() {
        let (x, y) = (MARGIN + i * pitch, MARGIN);
        // Writing to a String cannot fail.
        let _ = write!(
            svg,
            "<rect x=\"{x}\" y=\"{y}\" width=\"{}\" height=\"{}\" rx=\"6\" fill=\"#eef3f8\" stroke=\"#1f5fa8\"/>\
             <text x=\"{}\" y=\"{}\" text-anchor=\"middle\" font-weight=\"600\" fill=\"#1d2935\">{}</text>",
            BOX[0],
            BOX[1],
            x + BOX[0] / 2,
            y + 22,
            HtmlEscape(block.name)
        );
        for (k, line) in block.content.iter().enumerate() {
            let _ = write!(
                svg,
                "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\" font-size=\"12.5\" fill=\"#1d2935\">{}</text>",
                x + BOX[0] / 2,
                y + 44 + 18 * k,
                HtmlEscape(line)
            );
        }
    }
    for (i, words) in flows.iter().enumerate() {
        let (from, middle) = (MARGIN + BOX[0] + i * pitch, MARGIN + BOX[1] / 2);
        let _ = write!(
            svg,
            "<path d=\"M{from} {middle}h{}m-9 -5l9 5l-9 5\" fill=\"none\" stroke=\"#5b6875\" stroke-width=\"1.6\"/>",
            ARROW - 2
        );
        for (k, word) in words.iter().enumerate() {
            let _ = write!(
                svg,
                "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\" font-size=\"11.5\" fill=\"#5b6875\">{}</text>",
                from + ARROW / 2 - 4,
                middle - 10 + 28 * k,
                HtmlEscape(word)
            );
        }
    }
    svg + "</svg>"
}
