//! The library of property modules: rules of buses and streams, which a wrapper instantiates by name.

/// Name and source of each module. The comment at the head of a source lists rules, parameters and ports.
pub const MODULES: &[(&str, &str)] = &[
    ("avalon_stream", include_str!("../properties/avalon_stream.sv")),
    ("axi4_stream", include_str!("../properties/axi4_stream.sv")),
    ("avalon_slave", include_str!("../properties/avalon_slave.sv")),
    ("stream_order", include_str!("../properties/stream_order.sv")),
];

/// Returns the library modules that `properties` uses and does not define itself.
pub fn used_by(properties: &str) -> impl Iterator<Item = &'static (&'static str, &'static str)> {
    let code: Vec<&str> = properties.lines().map(|line| line.split("//").next().unwrap_or(line)).collect();
    MODULES.iter().filter(move |(name, _)| {
        let words = || code.iter().flat_map(|line| line.split(|c: char| !(c.is_alphanumeric() || c == '_')));
        let own = words().filter(|word| !word.is_empty()).collect::<Vec<_>>();
        own.contains(name) && !own.windows(2).any(|pair| pair == ["module", name])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modules_are_found_by_whole_names_outside_of_comments() {
        let named = |text: &str| used_by(text).map(|(name, _)| *name).collect::<Vec<_>>();
        assert_eq!(named("  axi4_stream #(.BYTES(4)) out (.aclk(aclk));\n"), ["axi4_stream"]);
        assert_eq!(named("// axi4_stream\nmy_axi4_stream a ();"), [""; 0]);
        assert_eq!(named("module axi4_stream (input a); endmodule\naxi4_stream b (.a(a));"), [""; 0]);
    }
}
