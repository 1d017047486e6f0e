//! The ports of the generated class, read from its header.

use super::hierarchy::{self, PortDirection, Variable};

/// Returns the ports of the generated class, as variables and the expressions of their members: in the order of the
/// source, then those that the description does not have.
pub(super) fn ports(header: &str, described: &[&Variable]) -> Vec<(Variable, String)> {
    let place = |name: &str| described.iter().position(|v| v.name == name);
    let mut found: Vec<(usize, Variable, String)> = Vec::new();
    for line in header.lines() {
        let Some((member, declared)) = parse_port(line) else { continue };
        let name = demangle(member);
        let expression = format!("TOP.{member}");
        match (place(&name), declared) {
            (Some(at), _) => found.push((at, described[at].clone(), expression)),
            (None, Some((port, width))) => {
                let variable = Variable {
                    path: name.clone(),
                    scope: String::new(),
                    name,
                    module: String::new(),
                    kind: hierarchy::Kind::Bits { width },
                    bits: (i64::from(width) - 1, 0),
                    signed: false,
                    items: Vec::new(),
                    fields: Vec::new(),
                    port: Some(port),
                    dimensions: Vec::new(),
                    nested: false,
                    register: false,
                };
                found.push((usize::MAX, variable, expression));
            }
            (None, None) => {}
        }
    }
    found.sort_by_key(|(at, ..)| *at);
    found.into_iter().map(|(_, variable, expression)| (variable, expression)).collect()
}

/// Parses the declaration of a port: the member and, if the line has them, direction and width. Known forms:
/// `VL_IN8(&name,7,0);`, `VL_OUTW(&name,69,0,3);`, `VL_IN8((&name)[4],7,0);`, `double &name;`,
/// `VlUnpacked<CData/*3:0*/, 2> &name;`.
fn parse_port(line: &str) -> Option<(&str, Option<(PortDirection, u32)>)> {
    let line = line.trim();
    let Some(rest) = line.strip_prefix("VL_") else {
        let (kind, member) = line.strip_suffix(';')?.rsplit_once('&')?;
        let is_port = kind.starts_with("VlUnpacked<") || kind.trim() == "double" || kind.trim() == "std::string";
        return is_port.then_some((member, None));
    };
    let (kind, arguments) = rest.split_once('(')?;
    let direction = match kind.trim_end_matches(|c: char| c.is_ascii_digit() || c == 'W') {
        "IN" => PortDirection::Input,
        "OUT" => PortDirection::Output,
        "INOUT" => PortDirection::Inout,
        _ => return None,
    };
    let arguments = arguments.strip_suffix(");")?;
    let mut fields = arguments.split(',');
    let name = fields.next()?;
    let member = name.trim_start_matches(['(', '&']).split([')', '[']).next()?;
    let (msb, lsb): (i64, i64) = (fields.next()?.parse().ok()?, fields.next()?.parse().ok()?);
    Some((member, Some((direction, u32::try_from(msb - lsb + 1).ok()?))))
}

/// Returns the Verilog name of a C++ member: `video$data` of `video__024data`, `delete` of `__SYM__delete`. Verilator
/// writes characters that C++ does not allow as `__0` and two hexadecimal digits, and a prefix before a word of C++.
fn demangle(member: &str) -> String {
    let mut name = String::new();
    let mut rest = member.strip_prefix("__SYM__").unwrap_or(member);
    while let Some(at) = rest.find("__0") {
        let code = rest.get(at + 3..at + 5).and_then(|digits| u8::from_str_radix(digits, 16).ok());
        match code {
            Some(code) if code.is_ascii_graphic() => {
                name.push_str(&rest[..at]);
                name.push(char::from(code));
                rest = &rest[at + 5..];
            }
            _ => {
                name.push_str(&rest[..at + 3]);
                rest = &rest[at + 3..];
            }
        }
    }
    name + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ports_are_read_from_the_header() {
        assert_eq!(parse_port("    VL_OUTW(&wide,69,0,3);"), Some(("wide", Some((PortDirection::Output, 70)))));
        assert_eq!(demangle("__SYM__delete"), "delete");
        assert_eq!(parse_port("    VL_INOUT8(&io__024x,3,0);"), Some(("io__024x", Some((PortDirection::Inout, 4)))));
        assert_eq!(parse_port("VL_IN16((&taps)[4],8,0);"), Some(("taps", Some((PortDirection::Input, 9)))));
        assert_eq!(parse_port("    VlUnpacked<VlUnpacked<CData/*3:0*/, 3>, 2> &grid;"), Some(("grid", None)));
        assert_eq!(parse_port("    double &gain;"), Some(("gain", None)));
        assert!(parse_port("    VL_UNCOPYABLE(Vdut);  ///< Copying not allowed").is_none());
        assert!(parse_port("    Vdut_beats* const& __PVT__link;").is_none());
    }

    #[test]
    fn mangled_names_come_back() {
        assert_eq!(demangle("video__024data"), "video$data");
        assert_eq!(demangle("plain_name__0"), "plain_name__0");
        assert_eq!(demangle("a__05Fb"), "a_b");
    }
}
