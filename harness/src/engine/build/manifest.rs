//! The manifest of a build: all files that Verilator read besides the sources, with hashes of their contents.

use std::path::{Path, PathBuf};

use super::files::read;
use super::job::BuildJob;
use crate::engine::error::BuildError;

impl BuildJob<'_> {
    /// Returns all files that Verilator read, except the sources, its own program and the file written for it.
    pub(super) fn read_manifest(&self, generated: &Path, root: &Path) -> Result<Vec<(PathBuf, String)>, BuildError> {
        let text = read(&generated.join("Vdut__verFiles.dat"))?;
        let names = files_read(&text);
        // Verilator lists the part of a name before its first blank, too, as if it were a file.
        let is_cut = |name: &str| {
            let longer = |other: &&str| other.strip_prefix(name).is_some_and(|rest| rest.starts_with([' ', '\t']));
            names.iter().any(longer) && !self.folder.join(name).is_file()
        };
        let own = |name: &str| name.ends_with("verilator_bin") || name == "public.vlt";
        let mut manifest = Vec::new();
        for name in names.iter().filter(|name| !own(name) && !is_cut(name)) {
            let path = super::absolute(&self.folder.join(name))?;
            // Its own library goes with the program, whose change makes another key.
            if !self.sources.contains(&path) && !path.starts_with(root) {
                let hash = super::model_cache::hash_file(&path)?;
                manifest.push((path, hash));
            }
        }
        manifest.sort();
        manifest.dedup();
        Ok(manifest)
    }
}

/// Returns the names of the files that were read, from lines like `S  99 10338340 1795274662 ... "a b/t.v"`; newer
/// versions put a hash in quotes before the name. Quotes in a name are not escaped. (The list for `make` is no use:
/// names with blanks are ambiguous there.)
fn files_read(text: &str) -> Vec<&str> {
    let quoted = |line: &'_ str| -> Option<(usize, usize)> {
        let (mut from, to) = (line.find('"')? + 1, line.rfind('"')?);
        let is_hash = |text: &str| {
            text == "unhashed"
                || text.len() == 40 && text.chars().all(|c| c.is_ascii_alphanumeric() || "+/=_-@".contains(c))
        };
        let first = line.get(from..)?.split_once("\" \"");
        if let Some((hash, _)) = first.filter(|(hash, _)| is_hash(hash)) {
            from += hash.len() + 3;
        }
        Some((from, to))
    };
    let lines = text.lines().filter(|line| line.starts_with("S "));
    lines.filter_map(|line| quoted(line).and_then(|(from, to)| line.get(from..to))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_read_have_blanks_and_quotes() {
        let text = "# DESCRIPTION: S\nC \"--cc a b.v\"\nS  99  1  2  3  2  3 \"/p/a b.v\"\n\
                    S 0 0 0 0 1 0 \"/q\"u/i.vh\"\nT  5  1  2  3  2  3 \"out/V.cpp\"\n";
        assert_eq!(files_read(text), ["/p/a b.v", "/q\"u/i.vh"]);
        let newer = "S  9  1  2  3  2  3 \"unhashed\" \"/p/bin\"\n\
                     S  9  1  2  3  2  3 \"czBlEFkcTVulpaEel4J0W5bCKNEsN5Xd0FA2B2DC\" \"/p/a\" \"b.v\"\n";
        assert_eq!(files_read(newer), ["/p/bin", "/p/a\" \"b.v"]);
    }
}
