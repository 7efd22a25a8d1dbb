//! Detection of the shaders that pack: they end in a call of the patched function of Bevy, of the pack function
//! itself, or of a function that does. What such a function returns is the result of such a call, and nothing changes
//! its colour in between. Alpha may change.

use std::{
    collections::{HashMap, HashSet},
    sync::{Arc, PoisonError, RwLock, RwLockReadGuard},
};

use bevy::{
    prelude::*,
    shader::{Shader, ShaderImport, Source},
};
use wesl::syntax::{
    AssignmentOperator, Attribute, CompoundStatement, Expression, Function, FunctionCall,
    GlobalDeclaration, GlobalDeclarationNode, ImportContent, Statement, TranslationUnit,
    UnaryOperator,
};

/// The pack function, and that of Bevy which is patched to end in it.
const PACKING: [&str; 2] = ["main_pass_post_lighting_processing", "pack_fragment"];

/// The shaders that pack the colours that they write. The main world and the render world share it.
#[derive(Resource, Clone, Debug, Default)]
pub(crate) struct PackingShaders(Arc<RwLock<Detected>>);

#[derive(Debug, Default)]
struct Detected {
    shaders: HashSet<AssetId<Shader>>,
    /// All shaders that are loaded.
    inspected: HashSet<AssetId<Shader>>,
    /// Incremented with every change of `shaders`.
    generation: u64,
}

impl PackingShaders {
    pub(crate) fn contains(&self, shader: AssetId<Shader>) -> bool {
        self.read().shaders.contains(&shader)
    }

    /// Whether the shader is loaded; pipelines of others are not ready.
    pub(crate) fn is_inspected(&self, shader: AssetId<Shader>) -> bool {
        self.read().inspected.contains(&shader)
    }

    /// Returns a number that changes whenever the result of `contains` may change.
    pub(crate) fn generation(&self) -> u64 {
        self.read().generation
    }

    fn read(&self) -> RwLockReadGuard<'_, Detected> {
        self.0.read().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Checks all shaders whenever one was loaded or changed.
pub(crate) fn find_packing_shaders(shaders: Res<Assets<Shader>>, packing: Res<PackingShaders>) {
    if !shaders.is_changed() {
        return;
    }
    let (ids, all): (Vec<_>, Vec<_>) = shaders.iter().unzip();
    let packing_ids = ids.iter().zip(shaders_that_pack(&all));
    let shaders = packing_ids.filter_map(|(id, packs)| packs.then_some(*id));
    let shaders: HashSet<_> = shaders.collect();
    let mut detected = packing.0.write().unwrap_or_else(PoisonError::into_inner);
    detected.inspected = ids.into_iter().collect();
    if detected.shaders != shaders {
        detected.shaders = shaders;
        detected.generation += 1;
    }
}

/// Returns whether the fragment shaders of each shader pack. Functions pack that end in a call of another one that
/// does, in the same shader or in one that it imports.
fn shaders_that_pack(shaders: &[&Shader]) -> Vec<bool> {
    let mut functions: HashMap<&ShaderImport, HashSet<String>> = HashMap::new();
    loop {
        let packings: Vec<_> = shaders
            .iter()
            .map(|shader| {
                let imported = shader.imports.iter().filter_map(|path| functions.get(path));
                let names: HashSet<_> = imported
                    .flatten()
                    .map(String::as_str)
                    .chain(PACKING)
                    .collect();
                match &shader.source {
                    // Most shaders mention none of them, and are not parsed.
                    Source::Wesl(source) | Source::Wgsl(source)
                        if names.iter().any(|&name| source.contains(name)) =>
                    {
                        packing(source, &names)
                    }
                    _ => Packing::default(),
                }
            })
            .collect();
        let mut grown = false;
        let fragments = packings.iter().map(|packing| packing.fragment).collect();
        for (shader, packing) in shaders.iter().zip(packings) {
            let known = functions.entry(&shader.import_path).or_default();
            for function in packing.functions {
                grown |= known.insert(function);
            }
        }
        if !grown {
            return fragments;
        }
    }
}

/// What is known of a shader.
#[derive(Debug, Default, PartialEq, Eq)]
struct Packing {
    /// The functions that return packed colours.
    functions: HashSet<String>,
    /// Whether the fragment shaders do.
    fragment: bool,
}

/// Returns which functions of a shader return packed colours, if those with these names do. A shader that cannot be
/// parsed has none.
fn packing(source: &str, names: &HashSet<&str>) -> Packing {
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
            let fragments = functions.iter().filter(|function| is_fragment(function));
            let flows = fragments.map(|function| Flow::of(function, &callees));
            let flows: Vec<_> = flows.collect();
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

    fn packs(sources: &[(&str, &str)]) -> Vec<bool> {
        let shaders: Vec<_> = sources
            .iter()
            .map(|(path, source)| Shader::from_wesl((*source).to_owned(), *path))
            .collect();
        shaders_that_pack(&shaders.iter().collect::<Vec<_>>())
    }

    #[test]
    fn shaders_pack_that_end_in_a_call_of_pack_or_of_a_function_that_does() {
        let library = "import bevy_ycocg_fb::shaders::pack::pack_fragment;\n\
            fn main_pass_post_lighting_processing(c: vec4<f32>) -> vec4<f32> {\n\
            return pack_fragment(c, c); }";
        let lit = "import bevy_pbr::render::pbr_functions::main_pass_post_lighting_processing;\n\
            @fragment fn f() -> O { return main_pass_post_lighting_processing(c); }";
        let own = "import bevy_ycocg_fb::shaders::pack::pack_fragment as pack;\n\
            @fragment fn f() -> O { let x = pack(c, p); return x; }";
        let module = "import bevy_pbr::render::pbr_functions as fns;\n\
            fn shade() -> vec4<f32> { return fns::main_pass_post_lighting_processing(c); }\n\
            fn other() -> vec4<f32> { return vec4(1.0); }";
        let through = "import package::shade::shade;\n@fragment fn f() -> O { return shade(); }";
        let beside =
            "import package::shade::{other, shade};\n@fragment fn f() -> O { return other(); }";
        let brighter =
            "import package::shade::shade;\n@fragment fn f() -> O { return 2.0 * shade(); }";
        let raw = "import bevy_pbr::render::pbr_functions::alpha_discard;\n\
            @fragment fn f() -> O { return c; }";
        assert_eq!(
            packs(&[
                ("embedded://bevy_pbr/render/pbr_functions.wesl", library),
                ("lit.wesl", lit),
                ("own.wesl", own),
                ("shade.wesl", module),
                ("through.wesl", through),
                ("beside.wesl", beside),
                ("brighter.wesl", brighter),
                ("raw.wesl", raw),
            ]),
            [false, true, true, false, true, false, false, false]
        );
    }

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
