//! Whether the functions of a shader end in a call that packs: what they return is the result of such a call, and
//! nothing changes its colour in between. Alpha may change.

use std::collections::HashSet;

use wesl::syntax::{
    AssignmentOperator, Attribute, CompoundStatement, Expression, Function, FunctionCall,
    GlobalDeclaration, GlobalDeclarationNode, ImportContent, Statement, TranslationUnit,
    UnaryOperator,
};

/// What is known of a shader.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Packing {
    /// The functions that return packed colours.
    pub functions: HashSet<String>,
    /// Whether the fragment shaders do.
    pub fragment: bool,
}

/// Returns which functions of a shader return packed colours, if those with these names do. A shader that cannot be
/// parsed has none.
pub(super) fn packing(source: &str, names: &HashSet<&str>) -> Packing {
    let Ok(unit) = source.parse::<TranslationUnit>() else {
        return Packing::default();
    };
    let mut functions = Vec::new();
    collect(&unit.global_declarations, &mut functions);
    let own: HashSet<String> = functions.iter().map(|f| f.ident.to_string()).collect();
    let mut known: HashSet<String> = names.iter().map(|&name| name.to_owned()).collect();
    for import in &unit.imports {
        renamed(&import.content, &mut known);
    }
    known.retain(|name| !own.contains(name));
    let mut packing = HashSet::new();
    loop {
        let callees: HashSet<_> = known.union(&packing).cloned().collect();
        let next: HashSet<_> = functions
            .iter()
            .filter(|function| Flow::of(function, &callees).packs())
            .map(|function| function.ident.to_string())
            .collect();
        if next == packing {
            let mut fragments = functions.iter().filter(|function| is_fragment(function));
            let flows: Vec<_> = fragments
                .by_ref()
                .map(|function| Flow::of(function, &callees))
                .collect();
            let fragment = flows.iter().any(Flow::packs)
                && flows.iter().all(|flow| flow.packs() || !flow.calls);
            return Packing {
                functions: packing,
                fragment,
            };
        }
        packing = next;
    }
}

fn collect<'a>(declarations: &'a [GlobalDeclarationNode], functions: &mut Vec<&'a Function>) {
    for declaration in declarations {
        match declaration.node() {
            GlobalDeclaration::Function(function) => functions.push(function),
            GlobalDeclaration::Compound(compound) => collect(&compound.body, functions),
            _ => {}
        }
    }
}

/// Adds the other names that a shader gives to what it imports.
fn renamed(content: &ImportContent, known: &mut HashSet<String>) {
    match content {
        ImportContent::Item(item) => {
            if let Some(rename) = &item.rename
                && known.contains(&*item.ident.name())
            {
                known.insert(rename.to_string());
            }
        }
        ImportContent::Collection(imports) => {
            for import in imports {
                renamed(&import.content, known);
            }
        }
    }
}

fn is_fragment(function: &Function) -> bool {
    let mut attributes = function.attributes.iter();
    attributes.any(|attribute| matches!(attribute.node(), Attribute::Fragment))
}

/// The variables that hold packed colours, by their paths such as `out.color`, along a function.
#[derive(Clone)]
struct Flow<'a> {
    callees: &'a HashSet<String>,
    packed: HashSet<String>,
    /// Whether a packed colour is returned, and whether any other value is.
    returns_packed: bool,
    returns_other: bool,
    /// Whether a packing function is called.
    calls: bool,
}

impl<'a> Flow<'a> {
    fn of(function: &Function, callees: &'a HashSet<String>) -> Self {
        let mut flow = Self {
            callees,
            packed: HashSet::new(),
            returns_packed: false,
            returns_other: false,
            calls: false,
        };
        flow.block(&function.body);
        flow
    }

    fn packs(&self) -> bool {
        self.returns_packed && !self.returns_other
    }

    /// Returns whether the block ends the function.
    fn block(&mut self, block: &CompoundStatement) -> bool {
        let mut ends = false;
        let statements = block.statements.iter().map(|statement| statement.node());
        for statement in statements.filter(|statement| !is_of_prepass(statement)) {
            ends |= self.statement(statement);
        }
        ends
    }

    fn statement(&mut self, statement: &Statement) -> bool {
        match statement {
            Statement::Compound(block) => {
                // Under a condition of translation it may not be there.
                self.block(block) && block.attributes.is_empty()
            }
            Statement::Declaration(declaration) => {
                if let Some(value) = &declaration.initializer {
                    self.assign(Some(declaration.ident.to_string()), value.node());
                }
                false
            }
            Statement::Assignment(assignment) => {
                let target = path(assignment.lhs.node());
                if assignment.operator == AssignmentOperator::Equal {
                    self.assign(target, assignment.rhs.node());
                } else if let Some(target) = target {
                    self.forget(&target);
                }
                false
            }
            Statement::FunctionCall(statement) => {
                self.call(&statement.call);
                false
            }
            Statement::Return(statement) => {
                if let Some(value) = &statement.expression {
                    if self.is_packed(value.node()) {
                        self.returns_packed = true;
                    } else {
                        self.returns_other = true;
                    }
                }
                statement.attributes.is_empty()
            }
            Statement::Discard(_) => true,
            Statement::If(statement) => {
                let mut bodies = vec![&statement.if_clause.body];
                bodies.extend(statement.else_if_clauses.iter().map(|clause| &clause.body));
                bodies.extend(statement.else_clause.iter().map(|clause| &clause.body));
                self.branch(&bodies, statement.else_clause.is_some())
            }
            Statement::Switch(statement) => {
                let bodies: Vec<_> = statement
                    .clauses
                    .iter()
                    .map(|clause| &clause.body)
                    .collect();
                self.branch(&bodies, true)
            }
            Statement::Loop(statement) => self.branch(&[&statement.body], false),
            Statement::For(statement) => self.branch(&[&statement.body], false),
            Statement::While(statement) => self.branch(&[&statement.body], false),
            _ => false,
        }
    }

    /// What is packed after all bodies that go on is packed. Returns whether all of them end the function, and one of them
    /// is always taken.
    fn branch(&mut self, bodies: &[&CompoundStatement], is_complete: bool) -> bool {
        let mut packed_after = (!is_complete).then(|| self.packed.clone());
        for body in bodies {
            let packed_before = self.packed.clone();
            let ends = self.block(body);
            let packed = std::mem::replace(&mut self.packed, packed_before);
            if !ends {
                packed_after = Some(match packed_after {
                    Some(others) => others.intersection(&packed).cloned().collect(),
                    None => packed,
                });
            }
        }
        match packed_after {
            Some(packed) => {
                self.packed = packed;
                false
            }
            None => true,
        }
    }

    fn assign(&mut self, target: Option<String>, value: &Expression) {
        let is_packed = self.is_packed(value);
        let Some(target) = target else {
            return;
        };
        self.forget(&target);
        if is_packed {
            self.packed.insert(target);
        }
    }

    /// Something else is written to the variable, unless it is its alpha.
    fn forget(&mut self, target: &str) {
        if !target.ends_with(".a") && !target.ends_with(".w") {
            self.packed
                .retain(|packed| !is_part(packed, target) && !is_part(target, packed));
        }
    }

    fn call(&mut self, call: &FunctionCall) -> bool {
        for argument in &call.arguments {
            if let Expression::Unary(unary) = argument.node()
                && unary.operator == UnaryOperator::AddressOf
                && let Some(target) = path(unary.operand.node())
            {
                self.forget(&target);
            }
        }
        let is_packing = self.callees.contains(&*call.ty.ident.name());
        self.calls |= is_packing;
        is_packing
    }

    fn is_packed(&mut self, value: &Expression) -> bool {
        match value {
            Expression::Parenthesized(inner) => self.is_packed(inner.expression.node()),
            Expression::FunctionCall(call) => {
                let name = call.ty.ident.to_string();
                let mut arguments = call.arguments.iter();
                if self.call(call) {
                    true
                } else if name == "vec4" || name == "vec4f" {
                    // With another alpha.
                    let color = arguments.next().and_then(|color| path(color.node()));
                    color.is_some_and(|color| {
                        let parts = color.rsplit_once('.');
                        parts.is_some_and(|(base, part)| {
                            (part == "rgb" || part == "xyz") && self.packed.contains(base)
                        })
                    })
                } else if name.starts_with(char::is_uppercase) {
                    // A struct.
                    arguments.any(|argument| self.is_packed(argument.node()))
                } else {
                    // The result of an inner call is changed.
                    for argument in arguments {
                        self.is_packed(argument.node());
                    }
                    false
                }
            }
            Expression::Binary(binary) => {
                self.is_packed(binary.left.node());
                self.is_packed(binary.right.node());
                false
            }
            Expression::NamedComponent(_) | Expression::TypeOrIdentifier(_) => path(value)
                .is_some_and(|path| self.packed.iter().any(|packed| is_part(packed, &path))),
            _ => false,
        }
    }
}

/// Whether a statement is there in prepasses only, which write other things than colours.
fn is_of_prepass(statement: &Statement) -> bool {
    let attributes = match statement {
        Statement::Compound(statement) => &statement.attributes,
        Statement::Declaration(statement) => &statement.attributes,
        Statement::Assignment(statement) => &statement.attributes,
        Statement::FunctionCall(statement) => &statement.attributes,
        Statement::If(statement) => &statement.attributes,
        Statement::Return(statement) => &statement.attributes,
        _ => return false,
    };
    attributes.iter().any(|attribute| {
        matches!(attribute.node(), Attribute::If(condition) if condition.to_string() == "PREPASS_PIPELINE")
    })
}

/// Whether a path is that of a variable or one of its members.
fn is_part(path: &str, variable: &str) -> bool {
    let rest = path.strip_prefix(variable);
    rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

fn path(expression: &Expression) -> Option<String> {
    match expression {
        Expression::TypeOrIdentifier(ty) => Some(ty.ident.to_string()),
        Expression::Parenthesized(inner) => path(inner.expression.node()),
        Expression::NamedComponent(member) => {
            let base = path(member.base.node())?;
            Some(format!("{base}.{}", member.component))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fragment_packs(body: &str) -> bool {
        let source = format!(
            "import bevy_pbr::render::pbr_functions::main_pass_post_lighting_processing;\n\
             @fragment fn fragment(in: VertexOutput) -> FragmentOutput {{\n{body}\n}}\n"
        );
        let names = HashSet::from(["main_pass_post_lighting_processing", "pack_fragment"]);
        packing(&source, &names).fragment
    }

    const CALL: &str = "out.color = main_pass_post_lighting_processing(pbr_input, out.color);";

    #[test]
    fn a_call_that_is_last_packs() {
        for rest in [
            "return out;",
            "return FragmentOutput(out.color, 0.5);",
            "out.depth = 0.5; return out;",
            "@if(FORWARD_DECAL) out.color.a = min(alpha, out.color.a); return out;",
            "if out.color.a < 0.5 { discard; } return out;",
            "let color = out.color; return FragmentOutput(color, 1.0);",
            "out.color = vec4(out.color.rgb, 1.0); return out;",
            "@if(OIT) { oit_draw(in.position, vec4(out.color.rgb * out.color.a, 1.0)); discard; } return out;",
        ] {
            assert!(
                fragment_packs(&format!("var out: FragmentOutput;\n{CALL}\n{rest}")),
                "{rest}"
            );
        }
        // As in materials that serve the deferred prepass, too.
        assert!(fragment_packs(&format!(
            "@if(PREPASS_PIPELINE) {{ return deferred_output(in, pbr_input); }}\n\
             @else {{ var out: FragmentOutput;\n{CALL}\nreturn out; }}"
        )));
        assert!(fragment_packs(
            "return (pack_fragment(color, in.position));"
        ));
        assert!(fragment_packs(
            "if unlit { return pack_fragment(a, in.position); } return pack_fragment(b, in.position);"
        ));
    }

    #[test]
    fn a_colour_that_is_changed_after_the_call_does_not() {
        for rest in [
            "out.color = out.color * 2.0; return out;",
            "out.color *= 2.0; return out;",
            "out.color.r = 1.0; return out;",
            "out = FragmentOutput(vec4(1.0), 0.0); return out;",
            "tint(&out); return out;",
            "if hit { out.color = vec4(1.0, 0.0, 0.0, 1.0); } return out;",
            "if hit { return FragmentOutput(vec4(1.0), 0.0); } return out;",
            "for (var i = 0; i < 3; i++) { out.color += glow; } return out;",
            "let c = out.color * 2.0; return FragmentOutput(c, 0.0);",
            "return FragmentOutput(mix(out.color, fog, 0.5), 0.0);",
        ] {
            assert!(
                !fragment_packs(&format!("var out: FragmentOutput;\n{CALL}\n{rest}")),
                "{rest}"
            );
        }
        assert!(!fragment_packs(
            "return pack_fragment(color, in.position) * 2.0;"
        ));
        assert!(!fragment_packs(
            "var c = raw; if lit { c = pack_fragment(raw, in.position); } return c;"
        ));
        assert!(!fragment_packs("return color;"));
    }

    #[test]
    fn a_function_of_the_same_name_is_not_that_of_bevy() {
        let source = "fn pack_fragment(c: vec4<f32>) -> vec4<f32> { return c; }\n\
            @fragment fn fragment() -> @location(0) vec4<f32> { return pack_fragment(c); }";
        assert!(!packing(source, &HashSet::from(["pack_fragment"])).fragment);
    }
}
