//! What a pixel fetches, counted by its own shader: the pixel shader of an app is composed as Bevy does, made
//! to count, and put in the place of the original, and the picture is read back. Loops and
//! branches count as often as they run, on a floor that is seen from near and far.
//!
//! Each call of a texture function gets its coordinates plus the zero of a function that counts, so it counts
//! exactly when it runs: in loops, in branches, and behind `&&`. What is counted are the calls in the WGSL as
//! Bevy composes it; a driver may still drop one whose result nobody reads.

use std::{collections::BTreeMap, ops::Range, path::Path};

use bevy::{
    prelude::*,
    render::{
        RenderApp,
        error_handler::{RenderErrorHandler, RenderErrorPolicy},
        render_resource::{CachedPipelineState, PipelineCache, PipelineDescriptor},
        renderer::RenderDevice,
    },
    shader::{Shader, ShaderDefVal},
};
use bevy_frugal_lab::{
    ROOT,
    compose::{Composer, device_defs},
    headless::HeadlessApp,
};
use naga::{
    Expression, Module, ScalarKind,
    valid::{Capabilities, FunctionInfo, ValidationFlags, Validator},
};
use serde::{Deserialize, Serialize};

use crate::{
    cost::{
        CostError,
        app::floor_app,
        configurations::{Configuration, Scene, configurations},
        pipelines::pass,
        tables::settings_table,
    },
    record::{FileError, read_json, write_json},
};

/// Frames whose mean is taken: some settings fetch different texels in even and odd frames.
const FRAMES: u32 = 2;
/// The pass of the plugin that is no material's, and is counted too.
const RESOLVE: &str = "packed_ycocg_resolve";

/// Counts the fetches of a plugin, or of all, and writes them into a folder beside those of the others.
pub fn measure(plugin: Option<&str>, folder: &Path) -> Result<(), CostError> {
    let is_selected = |name: &str| name == "bevy" || plugin.is_none_or(|plugin| plugin == name);
    let path = folder.join(FILE);
    let mut rows: Vec<FetchRow> = match path.exists() {
        true => read_json(&path)?,
        false => Vec::new(),
    };
    rows.retain(|row| !is_selected(&row.plugin));
    for configuration in configurations() {
        if !is_selected(configuration.plugin) || !configuration.changes_pixels() {
            continue;
        }
        for scene in [Scene::BaseColor, Scene::FiveMaps] {
            // The resolve depends on no material.
            let is_same = configuration.plugin == "ycocg_fb" && scene != Scene::BaseColor;
            if configuration.scenes.contains(&scene) && !is_same {
                let row = counted(&configuration, scene)?;
                println!(
                    "{}, {}: {:.1}",
                    configuration.name(),
                    row.material,
                    row.fetches()
                );
                rows.push(row);
            }
        }
    }
    Ok(write_json(&beside_bevy(rows), &path)?)
}

fn beside_bevy(mut rows: Vec<FetchRow>) -> Vec<FetchRow> {
    let is_bevys = |row: &&FetchRow| row.plugin == "bevy" && row.setting == "default";
    let bevys: Vec<_> = rows.iter().filter(is_bevys).cloned().collect();
    for row in &mut rows {
        let mut same = bevys
            .iter()
            .filter(|bevy| bevy.material == row.material && bevy.pass == row.pass);
        row.baseline_fetches = same.next().map(FetchRow::fetches);
    }
    rows
}

/// The fetches of a configuration in a scene.
pub fn counted(configuration: &Configuration, scene: Scene) -> Result<FetchRow, CostError> {
    let mut app = floor_app(&configuration.kind, scene)?;
    app.run_until_ready(crate::MAX_FRAMES)?;
    let pass = if configuration.plugin == "ycocg_fb" {
        RESOLVE
    } else {
        "forward"
    };
    let failed = |text: String| {
        CostError::Failed(format!(
            "{}, {}: {text}",
            configuration.name(),
            scene.material()
        ))
    };
    let (id, mut defs) = shader(&mut app, pass).ok_or_else(|| failed(format!("no pass {pass}")))?;
    defs.extend(device_defs(app.world().resource::<RenderDevice>()));
    let source = Composer::new(app.world())
        .compose(id, &defs)
        .map_err(failed)?;
    let counting = counting(&source).map_err(failed)?;
    // Pipelines of earlier frames have the shader, too, which may read a texture that their layout lacks. They are
    // refused, and draw nothing.
    app.world_mut()
        .insert_resource(RenderErrorHandler(|_, _, _| RenderErrorPolicy::Ignore));
    let render_world = app.app_mut().sub_app_mut(RenderApp).world_mut();
    let mut cache = render_world.resource_mut::<PipelineCache>();
    cache.set_shader(id, Shader::from_wgsl(counting, "counting.wgsl"));
    let mut sums = [0.0; KINDS.len()];
    for _ in 0..FRAMES {
        app.render_frames(1)?;
        let picture = app.capture_f32()?;
        let each = 1.0 / (f64::from(FRAMES) * picture.pixels.len() as f64);
        for pixel in &picture.pixels {
            if pixel.iter().any(|count| count.fract() != 0.0) {
                return Err(failed(format!("no counts but {pixel:?}")));
            }
            for (sum, count) in sums.iter_mut().zip(pixel) {
                *sum += f64::from(*count) * each;
            }
        }
    }
    let [samples, loads, gathers, comparisons] = sums.map(|sum| (sum * 100.0).round() / 100.0);
    Ok(FetchRow {
        plugin: configuration.plugin.into(),
        setting: configuration.setting.clone(),
        material: scene.material().into(),
        pass: pass.into(),
        samples,
        loads,
        gathers,
        comparisons,
        baseline_fetches: None,
    })
}

/// The pixel shader that a pass is drawn with.
fn shader(app: &mut HeadlessApp, name: &str) -> Option<(AssetId<Shader>, Vec<ShaderDefVal>)> {
    let cache = app
        .app_mut()
        .sub_app(RenderApp)
        .world()
        .resource::<PipelineCache>();
    let pipelines: Vec<_> = cache.pipelines().collect();
    // The last one is what the pass is drawn with, as `pipelines` says.
    let found = pipelines.into_iter().rev().find(|pipeline| {
        matches!(pipeline.state, CachedPipelineState::Ok(_))
            && pass(&pipeline.descriptor).is_some_and(|pass| pass == name)
    })?;
    let PipelineDescriptor::RenderPipelineDescriptor(descriptor) = &found.descriptor else {
        return None;
    };
    let fragment = descriptor.fragment.as_ref()?;
    Some((fragment.shader.id(), fragment.shader_defs.clone()))
}

/// Where the committed figures are, relative to the repository.
pub const FOLDER: &str = "docs/measurements/llvmpipe";
/// Name of the file in its folder.
pub const FILE: &str = "fetches.json";

/// The mean number of fetches of a pixel.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FetchRow {
    /// Name of the plugin, or `bevy`.
    pub plugin: String,
    /// Name of the setting.
    pub setting: String,
    /// Name of the material.
    pub material: String,
    /// Name of the pass.
    pub pass: String,
    /// Fetches through a filter.
    pub samples: f64,
    /// Fetches of one texel.
    pub loads: f64,
    /// Fetches of one component of four texels.
    pub gathers: f64,
    /// Comparisons with the depth in a shadow map.
    pub comparisons: f64,
    /// Fetches of all kinds by Bevy alone, where it has the pass.
    pub baseline_fetches: Option<f64>,
}

impl FetchRow {
    /// Fetches of all kinds.
    pub fn fetches(&self) -> f64 {
        self.samples + self.loads + self.gathers + self.comparisons
    }
}

/// Reads the committed figures.
pub fn read() -> Result<Vec<FetchRow>, FileError> {
    let root = Path::new(ROOT);
    read_json(&root.join(FOLDER).join(FILE))
}

/// The table of a plugin's page: fetches of a pixel by setting.
pub fn page(rows: &[FetchRow], plugin: &str) -> String {
    let own: Vec<_> = rows.iter().filter(|row| row.plugin == plugin).collect();
    let names: Vec<_> = [Scene::BaseColor, Scene::FiveMaps]
        .map(Scene::material)
        .into_iter()
        .filter(|name| own.iter().any(|row| row.material == *name))
        .collect();
    let has_bevys = own.iter().any(|row| row.baseline_fetches.is_some());
    let settings = own.iter().map(|row| row.setting.as_str());
    settings_table(&names, plugin, has_bevys, settings, |plugin, setting| {
        let cells = names.iter().map(|material| {
            let is_it = |row: &&FetchRow| {
                row.plugin == plugin && row.setting == setting && row.material == *material
            };
            rows.iter().find(is_it).map_or(String::new(), cell)
        });
        cells.collect()
    })
}

/// All fetches, and over Bevy's; then by kind.
fn cell(row: &FetchRow) -> String {
    let fetches = row.fetches();
    let factor = { row.baseline_fetches.filter(|_| row.plugin != "bevy") }
        .map_or(String::new(), |bevy| format!(" ({:.1})", fetches / bevy));
    let kinds = [row.samples, row.loads, row.gathers, row.comparisons];
    let kinds = kinds.map(|count| format!("{count:.1}"));
    format!("{fetches:.1}{factor}: {}", kinds.join(" + "))
}

/// The kinds of fetches, in the order of the counts: through a filter, of one texel, of one component of four
/// texels, and comparisons with the depth in a shadow map.
pub const KINDS: [&str; 4] = ["samples", "loads", "gathers", "comparisons"];

const COUNTERS: &str = "
var<private> fetch_counts: vec4<f32>;
fn counted_0_Float() -> f32 { fetch_counts.x += 1.0; return 0.0; }
fn counted_1_Sint() -> i32 { fetch_counts.y += 1.0; return 0; }
fn counted_1_Uint() -> u32 { fetch_counts.y += 1.0; return 0u; }
fn counted_2_Float() -> f32 { fetch_counts.z += 1.0; return 0.0; }
fn counted_3_Float() -> f32 { fetch_counts.w += 1.0; return 0.0; }
";

/// The shader with a pixel shader of the same name and parameters that returns the counts, in the order of
/// [`KINDS`]. `source` is plain WGSL with one pixel shader.
pub fn counting(source: &str) -> Result<String, String> {
    let mut text = source.to_owned();
    let mut insertions = Vec::new();
    let load_kinds = load_kinds(source)?;
    for call in calls(source) {
        let name = &source[call.clone()];
        let arguments = arguments(source, call.end).ok_or("an open parenthesis")?;
        let (kind, index) = match name {
            "textureLoad" => (1, 1),
            _ if name.contains("Compare") => (3, 2),
            // The component comes first where the texture has several.
            "textureGather" if is_component(&source[arguments[0].clone()]) => (2, 3),
            "textureGather" => (2, 2),
            _ => (0, 2),
        };
        let scalar = match kind {
            1 => *load_kinds.get(&call.start).ok_or("a load of no type")?,
            _ => ScalarKind::Float,
        };
        let coordinates = arguments.get(index).ok_or("a fetch without coordinates")?;
        insertions.push((coordinates.start, "(".to_owned()));
        insertions.push((coordinates.end, format!(") + counted_{kind}_{scalar:?}()")));
    }
    insertions.sort_by_key(|(position, _)| std::cmp::Reverse(*position));
    for (position, inserted) in insertions {
        text.insert_str(position, &inserted);
    }
    Ok(with_entry(&text).ok_or("no pixel shader")? + COUNTERS)
}

/// Where the names of functions that fetch are in calls; a parenthesis follows each.
fn calls(source: &str) -> impl Iterator<Item = Range<usize>> {
    let fetches = ["textureSample", "textureGather", "textureLoad"];
    source
        .match_indices("texture")
        .filter_map(move |(start, _)| {
            let before = source[..start].chars().next_back();
            let is_word = |c: char| c.is_alphanumeric() || c == '_';
            let length = source[start..].find(|c| !is_word(c))?;
            let name = start..start + length;
            let is_fetch = fetches.iter().any(|f| source[name.clone()].starts_with(f));
            let is_call = source[name.end..].starts_with('(') && !before.is_some_and(is_word);
            (is_fetch && is_call).then_some(name)
        })
}

/// The type of the coordinates of each `textureLoad`, by where its name begins.
fn load_kinds(source: &str) -> Result<BTreeMap<usize, ScalarKind>, String> {
    let module =
        naga::front::wgsl::parse_str(source).map_err(|error| error.emit_to_string(source))?;
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::all());
    let info = validator.validate(&module);
    let info = info.map_err(|error| error.emit_to_string(source))?;
    let mut kinds = BTreeMap::new();
    for (handle, function) in module.functions.iter() {
        add_load_kinds(&module, function, &info[handle], &mut kinds);
    }
    for (index, entry) in module.entry_points.iter().enumerate() {
        add_load_kinds(
            &module,
            &entry.function,
            info.get_entry_point(index),
            &mut kinds,
        );
    }
    Ok(kinds)
}

fn add_load_kinds(
    module: &Module,
    function: &naga::Function,
    info: &FunctionInfo,
    kinds: &mut BTreeMap<usize, ScalarKind>,
) {
    for (handle, expression) in function.expressions.iter() {
        if let Expression::ImageLoad { coordinate, .. } = *expression
            && let Some(range) = function.expressions.get_span(handle).to_range()
            && let Some(kind) = info[coordinate].ty.inner_with(&module.types).scalar_kind()
        {
            kinds.insert(range.start, kind);
        }
    }
}

fn is_component(argument: &str) -> bool {
    argument.trim().starts_with(|c: char| c.is_ascii_digit())
}

/// Where the arguments between the parentheses at `open` are.
fn arguments(source: &str, open: usize) -> Option<Vec<Range<usize>>> {
    let mut depth = 0_u32;
    let mut start = open + 1;
    let mut found = Vec::new();
    for (offset, c) in source[open..].char_indices() {
        let at = open + offset;
        match c {
            '(' | '[' => depth += 1,
            ')' | ']' => depth -= 1,
            _ => {}
        }
        if depth == 0 || depth == 1 && c == ',' {
            if !source[start..at].trim().is_empty() {
                found.push(start..at);
            }
            start = at + 1;
        }
        if depth == 0 {
            return Some(found);
        }
    }
    None
}

/// The pixel shader as an ordinary function, and a new one that calls it.
fn with_entry(source: &str) -> Option<String> {
    const ATTRIBUTE: &str = "@fragment";
    let start = source.find(ATTRIBUTE)?;
    let name_start = start + source[start..].find("fn ")? + 3;
    let open = name_start + source[name_start..].find('(')?;
    let name = &source[name_start..open];
    let ranges = arguments(source, open)?;
    let end = ranges.last().map_or(open + 1, |last| last.end);
    let parameters: Vec<_> = { ranges.into_iter() }
        .map(|range| source[range].trim())
        .collect();
    let body = end + source[end..].find('{')?;
    // What is returned may have an attribute, too.
    let result = source[end..body].split_once("->").map(|(_, result)| result);
    let result = result.map_or(String::new(), |r| format!("-> {}", without_attributes(r)));
    let plain: Vec<_> = { parameters.iter() }
        .map(|parameter| without_attributes(parameter))
        .collect();
    let names: Vec<_> = { plain.iter() }
        .filter_map(|parameter| parameter.split(':').next())
        .collect();
    let (before, after) = (&source[..start], &source[body..]);
    Some(format!(
        "{before}fn uncounted_{name}({}) {result} {after}\n\
         @fragment\nfn {name}({}) -> @location(0) vec4<f32> {{\n    \
         _ = uncounted_{name}({});\n    return fetch_counts;\n}}\n",
        plain.join(", "),
        parameters.join(", "),
        names.join(", "),
    ))
}

/// A parameter or a type without the attributes before it.
fn without_attributes(text: &str) -> &str {
    let mut rest = text.trim();
    while let Some(attribute) = rest.strip_prefix('@') {
        let name = attribute.find(|c: char| !c.is_alphanumeric() && c != '_');
        rest = attribute[name.unwrap_or(attribute.len())..].trim_start();
        if rest.starts_with('(') {
            rest = rest
                .split_once(')')
                .map_or("", |(_, rest)| rest)
                .trim_start();
        }
    }
    rest
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHADER: &str = "
@group(0) @binding(0) var t: texture_2d<f32>;
@group(0) @binding(1) var s: sampler;
@group(0) @binding(2) var d: texture_depth_2d;
@group(0) @binding(3) var c: sampler_comparison;
struct Output { @location(0) color: vec4<f32> }
fn level(at: vec2<f32>) -> f32 { return textureSampleLevel(t, s, at, 0.0).x; }
@fragment
fn fragment(@builtin(position) at: vec4<f32>, @builtin(front_facing) is_front: bool) -> Output {
    var sum = vec4(level(textureSampleLevel(t, s, at.xy, 1.0).xy));
    for (var i = 0; i < 3; i++) { sum += textureLoad(t, vec2<i32>(at.xy) + i, 0); }
    if (textureLoad(t, vec2<u32>(at.xy), 0u).x > 2.0 && textureLoad(t, vec2(0), 0).x > 0.0) {
        sum += textureGather(1, t, s, at.xy);
    }
    sum += textureGather(d, s, at.xy) * textureSampleCompareLevel(d, c, at.xy, 0.5);
    return Output(sum);
}
";

    #[test]
    fn every_call_is_counted_by_its_kind_and_the_result_is_valid() {
        let counting = counting(SHADER).expect("counted");
        let valid = load_kinds(&counting);
        assert!(valid.is_ok(), "{}\n{counting}", valid.unwrap_err());
        let calls = |name: &str| counting.matches(&format!("+ {name}()")).count();
        let names = ["counted_0_Float", "counted_1_Sint", "counted_1_Uint"];
        assert_eq!(names.map(calls), [2, 2, 1]);
        assert_eq!(["counted_2_Float", "counted_3_Float"].map(calls), [2, 1]);
        assert_eq!(counting.matches("@fragment").count(), 1);
        assert!(
            counting.contains("fn uncounted_fragment(at: vec4<f32>, is_front: bool) -> Output {")
        );
    }

    #[test]
    fn a_shader_without_an_entry_is_refused() {
        assert!(counting("fn f() {}").is_err());
    }
}
