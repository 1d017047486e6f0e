//! The description as JSON, `--json-only`, of versions from 5.024 on: nodes with a type, a name, and lists of nodes
//! below. Other nodes are named by their address, a text such as `(AB)`.

use serde_json::Value;

use super::registers::{Access, Process, Reference};
use super::{Declaration, Design, EnumItems, Hierarchy, Module, PortDirection, Type, bound, constant, parameter};
use crate::engine::error::BuildError;

fn text<'a>(node: &'a Value, key: &str) -> &'a str {
    node.get(key).and_then(Value::as_str).unwrap_or_default()
}

fn list<'a>(node: &'a Value, key: &str) -> &'a [Value] {
    node.get(key).and_then(Value::as_array).map(Vec::as_slice).unwrap_or_default()
}

fn flag(node: &Value, key: &str) -> bool {
    node.get(key).and_then(Value::as_bool).unwrap_or(false)
}

/// Returns the text of the constant that a list begins with.
fn constant_text(node: &Value, key: &str) -> Option<String> {
    let of = list(node, key).first().filter(|of| text(of, "type") == "CONST")?;
    // A string's quotes are escaped once more than JSON asks for.
    Some(text(of, "name").replace("\\\"", "\""))
}

fn bounds(node: &Value) -> Option<(i64, i64)> {
    let range = list(node, "rangep").first()?;
    let of = |key| bound(&constant_text(range, key)?);
    Some((of("leftp")?, of("rightp")?))
}

/// Adds what a module, or a block in it, declares and refers to. `nested` is `true` in a function, a task or an unnamed
/// block, `running` in a block whose references are added as one.
fn add_statements(statements: &[Value], blocks: &[&str], nested: bool, running: bool, into: &mut Module) {
    let references = |node: &Value| {
        let mut found = Vec::new();
        add_references(node, blocks, None, &mut found);
        found
    };
    for node in statements {
        match text(node, "type") {
            "VAR" => add_variable(node, blocks, nested, into),
            "CELL" => {
                let path = blocks.iter().copied().chain([text(node, "name")]).collect::<Vec<_>>().join(".");
                into.add_instances(path, text(node, "modp").to_owned(), bounds(node));
                references(&node["pinsp"]).into_iter().for_each(|of| into.references.add_outside(of));
            }
            "GENBLOCK" | "BEGIN" => {
                let name = text(node, "name");
                let mut inner = blocks.to_vec();
                if !name.is_empty() {
                    inner.push(name);
                }
                for key in ["itemsp", "stmtsp", "declsp"] {
                    add_statements(list(node, key), &inner, nested || name.is_empty(), running, into);
                }
            }
            "FUNC" | "TASK" => {
                for key in ["fvarp", "stmtsp"] {
                    add_statements(list(node, key), blocks, true, true, into);
                }
                into.references.add_task(references(&node["stmtsp"]));
            }
            "ALWAYS" | "INITIAL" | "INITIALSTATIC" | "FINAL" => {
                add_statements(list(node, "stmtsp"), blocks, nested, true, into);
                let mut items = list(node, "sentreep").iter().flat_map(|tree| list(tree, "sensesp"));
                let has_edge = items.any(|item| matches!(text(item, "edgeType"), "POS" | "NEG" | "BOTH"));
                into.references.add(Process { has_edge, references: references(&node["stmtsp"]) });
            }
            _ if !running => references(node).into_iter().for_each(|of| into.references.add_outside(of)),
            _ => {}
        }
    }
}

/// Adds the references in a node or a list of nodes, in the order of evaluation. `target` says which assignment the
/// node is the target of.
fn add_references(node: &Value, blocks: &[&str], target: Option<Access>, into: &mut Vec<Reference>) {
    let members = match node {
        Value::Array(nodes) => {
            nodes.iter().for_each(|node| add_references(node, blocks, target, into));
            return;
        }
        Value::Object(members) => members,
        _ => return,
    };
    let kind = text(node, "type");
    let assigns = match kind {
        "ASSIGN" => Some(Access::Assigned),
        "ASSIGNDLY" => Some(Access::Clocked),
        _ => None,
    };
    if assigns.is_some() {
        add_references(&node["rhsp"], blocks, None, into);
        add_references(&node["lhsp"], blocks, assigns, into);
        return;
    }
    if kind == "VARREF" {
        let blocks = blocks.iter().map(|block| format!("{block}.")).collect();
        let access = target.unwrap_or(Access::Read);
        into.push(Reference { blocks, name: text(node, "name").to_owned(), access });
        return;
    }
    let name = text(node, "name");
    let mut inner = blocks.to_vec();
    if kind == "BEGIN" && !name.is_empty() {
        inner.push(name);
    }
    for (key, below) in members {
        // What is selected from a target is the target, and its place is read.
        let is_target = matches!(kind, "CONCAT" | "CONCATN") || key == "fromp";
        add_references(below, &inner, target.filter(|_| is_target), into);
    }
}

fn add_variable(node: &Value, blocks: &[&str], nested: bool, into: &mut Module) {
    let name = text(node, "name").to_owned();
    if flag(node, "isParam") {
        if let Some(value) = constant_text(node, "valuep").and_then(|text| parameter(&text))
            && blocks.is_empty()
            && !nested
        {
            into.constants.push((name, value));
        }
        return;
    }
    // These are no variables of the model.
    if matches!(text(node, "varType"), "GENVAR" | "IFACEREF") {
        return;
    }
    into.variables.push(Declaration {
        name,
        blocks: blocks.iter().map(|block| format!("{block}.")).collect(),
        type_id: text(node, "dtypep").to_owned(),
        type_name: text(node, "dtypeName").to_owned(),
        port: match text(node, "direction") {
            "INPUT" => Some(PortDirection::Input),
            "OUTPUT" => Some(PortDirection::Output),
            "INOUT" => Some(PortDirection::Inout),
            _ => None,
        },
        nested,
    });
}

fn add_type(node: &Value, design: &mut Design) {
    let id = text(node, "addr").to_owned();
    let of = text(node, "refDTypep").to_owned();
    let members = || {
        let named = |m: &Value| (text(m, "name").to_owned(), text(m, "dtypep").to_owned());
        list(node, "membersp").iter().map(named).collect()
    };
    let found = match text(node, "type") {
        "BASICDTYPE" => {
            let bits = match text(node, "range").split_once(':') {
                Some((left, right)) => left.parse().ok().zip(right.parse().ok()),
                None => Some((0, 0)),
            };
            Type::Basic { keyword: text(node, "keyword").to_owned(), bits, signed: flag(node, "signed") }
        }
        kind @ ("UNPACKARRAYDTYPE" | "PACKARRAYDTYPE") => {
            let Some(bounds) = bounds(node) else { return };
            Type::Array { of, bounds, packed: kind == "PACKARRAYDTYPE" }
        }
        "STRUCTDTYPE" => Type::Struct { members: members(), packed: Some(flag(node, "packed")) },
        "UNIONDTYPE" if !flag(node, "packed") => return,
        "UNIONDTYPE" => Type::Union { members: members() },
        "ENUMDTYPE" => {
            let item = |i: &Value| Some((text(i, "name").to_owned(), constant(&constant_text(i, "valuep")?)?));
            let items: EnumItems = list(node, "itemsp").iter().filter_map(item).collect();
            let name = text(node, "name").to_owned();
            design.types.enumerations.insert(name.clone(), items);
            design.types.enumeration_names.insert(id.clone(), name);
            Type::Same { of }
        }
        "REFDTYPE" | "CONSTDTYPE" | "MEMBERDTYPE" => Type::Same { of },
        _ => return,
    };
    design.types.types.insert(id, found);
}

/// Reads the JSON; `top` is the top module's name.
pub fn parse(json: &str, top: &str) -> Result<Hierarchy, BuildError> {
    let unexpected = |reason: String| BuildError::Unexpected { what: "JSON", reason };
    let root: Value = serde_json::from_str(json).map_err(|error| unexpected(error.to_string()))?;
    let mut design = Design::default();
    let mut tables = list(&root, "miscsp").iter().filter(|node| text(node, "type") == "TYPETABLE").peekable();
    // It is empty if the design has no variables.
    if tables.peek().is_none() {
        return Err(unexpected("it has no table of types".into()));
    }
    tables.for_each(|table| list(table, "typesp").iter().for_each(|of| add_type(of, &mut design)));
    let is_module = |node: &&Value| matches!(text(node, "type"), "MODULE" | "IFACE");
    for node in list(&root, "modulesp").iter().filter(is_module) {
        let mut module = Module { original: text(node, "origName").to_owned(), ..Module::default() };
        add_statements(list(node, "stmtsp"), &[], false, false, &mut module);
        let address = text(node, "addr").to_owned();
        if text(node, "type") == "MODULE" && module.original == top && design.top.is_none() {
            design.top = Some((top.to_owned(), address.clone()));
        }
        design.modules.insert(address, module);
    }
    design.expand("JSON")
}

#[cfg(test)]
mod tests {
    use super::super::{Constant, Kind, Step, Variable};
    use super::*;

    const JSON: &str = r#"{"type":"NETLIST","modulesp":[
      {"type":"MODULE","name":"t","addr":"(E)","origName":"t","stmtsp":[
        {"type":"VAR","name":"W","isParam":true,"dtypep":"(I)","valuep":[{"type":"CONST","name":"32'sh8"}]},
        {"type":"VAR","name":"S","isParam":true,"dtypep":"(S)","valuep":[{"type":"CONST","name":"\"a b\""}]},
        {"type":"VAR","name":"clk","dtypep":"(A)","direction":"INPUT","varType":"PORT","dtypeName":"logic"},
        {"type":"VAR","name":"i","dtypep":"(I)","varType":"GENVAR","direction":"NONE"},
        {"type":"VAR","name":"st","dtypep":"(R)","direction":"NONE","varType":"VAR","dtypeName":"st_t"},
        {"type":"GENBLOCK","name":"lane[0]","itemsp":[
          {"type":"CELL","name":"u","modp":"(F)"},
          {"type":"GENBLOCK","name":"","itemsp":[{"type":"VAR","name":"hidden","dtypep":"(A)","varType":"VAR"}]}]},
        {"type":"CELL","name":"bus","modp":"(X)","rangep":[{"type":"RANGE",
          "leftp":[{"type":"CONST","name":"32'h0"}],"rightp":[{"type":"CONST","name":"32'h1"}]}]},
        {"type":"VAR","name":"bus__Viftop","dtypep":"(A)","varType":"IFACEREF","direction":"NONE"},
        {"type":"FUNC","name":"f","fvarp":[{"type":"VAR","name":"f","dtypep":"(A)","varType":"VAR"}]}]},
      {"type":"IFACE","name":"t","addr":"(X)","origName":"t","stmtsp":[
        {"type":"VAR","name":"beat","dtypep":"(A)","varType":"VAR","direction":"NONE"}]},
      {"type":"MODULE","name":"sub__W8","addr":"(F)","origName":"sub","stmtsp":[
        {"type":"VAR","name":"mem","dtypep":"(M)","varType":"VAR","direction":"NONE"},
        {"type":"VAR","name":"loose","dtypep":"(L)","varType":"VAR","direction":"NONE"}]}],
     "miscsp":[{"type":"TYPETABLE","typesp":[
      {"type":"BASICDTYPE","addr":"(A)","keyword":"logic"},
      {"type":"BASICDTYPE","addr":"(I)","keyword":"int","range":"31:0","signed":true},
      {"type":"BASICDTYPE","addr":"(S)","keyword":"string"},
      {"type":"ENUMDTYPE","addr":"(N)","name":"t.st_t","refDTypep":"(P)","itemsp":[
        {"type":"ENUMITEM","name":"IDLE","valuep":[{"type":"CONST","name":"2'h0"}]},
        {"type":"ENUMITEM","name":"RUN","valuep":[{"type":"CONST","name":"2'h2"}]}]},
      {"type":"REFDTYPE","addr":"(R)","refDTypep":"(N)"},
      {"type":"BASICDTYPE","addr":"(P)","keyword":"logic","range":"1:0"},
      {"type":"STRUCTDTYPE","addr":"(L)","membersp":[{"name":"x","dtypep":"(A)"}]},
      {"type":"UNPACKARRAYDTYPE","addr":"(M)","refDTypep":"(O)","rangep":[{"type":"RANGE",
        "leftp":[{"type":"CONST","name":"32'hfffffffe"}],"rightp":[{"type":"CONST","name":"32'sh4"}]}]},
      {"type":"UNPACKARRAYDTYPE","addr":"(O)","refDTypep":"(I)","rangep":[{"type":"RANGE",
        "leftp":[{"type":"CONST","name":"32'sh0"}],"rightp":[{"type":"CONST","name":"32'sh2"}]}]}]}]}"#;

    #[test]
    fn variables_types_and_parameters_are_found() {
        let found = parse(JSON, "t").unwrap();
        let paths: Vec<&str> = found.variables.iter().map(|v| v.path.as_str()).collect();
        let instances = ["lane[0].u.mem", "lane[0].u.loose", "bus[0].beat", "bus[1].beat"];
        assert_eq!((&paths[..4], &paths[4..]), (&["clk", "st", "lane[0].hidden", "f"][..], &instances[..]));
        let of = |path: &str| -> &Variable { found.variables.iter().find(|v| v.path == path).unwrap() };
        assert_eq!((of("clk").port, of("st").port), (Some(PortDirection::Input), None));
        assert_eq!(of("st").items, [("IDLE".to_owned(), 0), ("RUN".to_owned(), 2)]);
        assert!(of("lane[0].hidden").nested && of("f").nested && !of("st").nested);
        let memory = of("lane[0].u.mem");
        assert_eq!((memory.scope.as_str(), memory.module.as_str()), ("t.lane[0].u", "sub"));
        assert_eq!((&memory.dimensions[..], memory.kind), (&[(-2, 4), (0, 2)][..], Kind::Bits { width: 32 }));
        assert!(memory.signed);
        assert_eq!(of("lane[0].u.loose").kind, Kind::Other, "an unpacked structure");
        let [part] = &found.structures["lane[0].u.loose"][..] else { panic!("one field") };
        assert_eq!((part.variable.path.as_str(), part.variable.kind), ("lane[0].u.loose.x", Kind::Bits { width: 1 }));
        assert_eq!(part.steps, [Step::Member("x".into())]);
        assert_eq!(found.constants[0], ("W".to_owned(), Constant::Number(8)));
        assert_eq!(found.constants[1], ("S".to_owned(), Constant::Text("a b".to_owned())));
    }

    #[test]
    fn a_top_may_have_no_variables() {
        let empty = r#"{"modulesp":[{"type":"MODULE","addr":"(E)","origName":"t","stmtsp":[]}],
          "miscsp":[{"type":"TYPETABLE","typesp":[{"type":"VOIDDTYPE","addr":"(F)"}]}]}"#;
        assert!(parse(empty, "t").unwrap().variables.is_empty());
    }

    #[test]
    fn what_is_no_description_is_refused() {
        assert!(parse("{", "t").is_err() && parse("{}", "t").is_err());
        assert!(parse(JSON, "other").unwrap_err().to_string().contains("top module"));
    }
}
