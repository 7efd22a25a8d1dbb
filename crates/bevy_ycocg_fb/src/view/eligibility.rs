//! The choice of the cameras that use another format. Cameras that share a picture have one.

use bevy::{
    camera::{MsaaWriteback, NormalizedRenderTarget},
    ecs::{
        entity::{EntityHashMap, EntityHashSet},
        system::SystemParam,
    },
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{Texture, TextureFormat, TextureUsages},
        renderer::{RenderAdapter, RenderAdapterInfo, RenderDevice},
        sync_world::MainEntity,
        texture::CachedTexture,
        view::{ExtractedView, ViewTarget},
    },
};
use bevy_frugal_hooks::format_features;

use super::{
    conditions::{
        Candidate, CandidateItem, MainPassSystems, MainWorldState, Refusals, draws_colors,
        hardware_resolve,
    },
    formatted::{Formatted, PackedComponents, PackedTextures, PackedView, Rg11b10UfloatView},
};
use crate::{
    material::detect::PackingShaders,
    report::{
        CameraState, ColorMemory, FallbackReason, FrameBufferReport, RefusedFormat, RenderedReports,
    },
    settings::{FrameBufferFormat, FrameBufferQuality, PackedFormat},
};

/// What was chosen in this frame, by camera in the main world.
#[derive(Resource, Debug, Default)]
pub(super) struct Decisions(EntityHashMap<(CameraState, Vec<RefusedFormat>)>);

/// The views whose format is another than in the last frame.
#[derive(Resource, Debug, Default)]
pub(crate) struct SwitchedViews {
    pub views: EntityHashSet,
    previous: EntityHashMap<Option<FrameBufferFormat>>,
}

/// What decides whether a camera can use a format.
#[derive(SystemParam)]
pub(super) struct Conditions<'w, 's> {
    views: Query<'w, 's, &'static ExtractedView>,
    state: Res<'w, MainWorldState>,
    systems: Res<'w, MainPassSystems>,
    clear_color: Res<'w, ClearColor>,
    adapter: Res<'w, RenderAdapter>,
    device: Res<'w, RenderDevice>,
}

/// A camera with the formats that remain for it to try.
struct Choice<'a, 'w, 's> {
    candidate: &'a CandidateItem<'w, 's>,
    remaining: Vec<FrameBufferFormat>,
    refused: Vec<RefusedFormat>,
}

impl Choice<'_, '_, '_> {
    fn preferred(&self) -> Option<FrameBufferFormat> {
        self.remaining.first().copied()
    }

    fn refuse(&mut self, reason: FallbackReason) {
        if !self.remaining.is_empty() {
            let format = self.remaining.remove(0);
            self.refused.push(RefusedFormat { format, reason });
        }
    }

    /// Refuses the formats that the camera cannot use by itself.
    fn refuse_impossible(&mut self, conditions: &Conditions, refusals: &Refusals) {
        while let Some(format) = self.preferred()
            && let Some(reason) = conditions.reason(self.candidate, format, refusals)
        {
            self.refuse(reason);
        }
    }
}

/// Inserts [`PackedView`] or [`Rg11b10UfloatView`] for the cameras that can use a format of theirs, and removes them
/// from the others.
pub(super) fn select_views(
    mut commands: Commands,
    candidates: Query<Candidate>,
    formatted: Query<Entity, Formatted>,
    conditions: Conditions,
    mut refusals: ResMut<Refusals>,
    mut decisions: ResMut<Decisions>,
    mut switched: ResMut<SwitchedViews>,
    shaders: Res<PackingShaders>,
) {
    decisions.0.clear();
    switched.views.clear();
    if formatted.is_empty() && candidates.iter().all(|c| c.quality.is_none()) {
        // A camera whose first quality comes later switches from Bevy's format.
        switched.previous.clear();
        let cameras = candidates.iter().map(|candidate| (candidate.entity, None));
        switched.previous.extend(cameras);
        return;
    }
    refusals.keep_current(&candidates, &shaders);
    // Cameras without a size are not drawn.
    let cameras: Vec<_> = candidates
        .iter()
        .filter(|candidate| candidate.camera.physical_target_size.is_some())
        .collect();
    let layers: Vec<_> = cameras.iter().map(Layer::of).collect();
    // While Bevy's shaders are loading, as in the first frames, they are not patched yet.
    let is_loading = !conditions.state.patched && conditions.state.refused.is_none();
    let choices = choose_formats(&cameras, &layers, &conditions, &refusals);

    let mut views = formatted.iter().collect::<EntityHashSet>();
    let mut formats = EntityHashMap::default();
    for (i, choice) in choices.iter().enumerate() {
        let candidate = choice.candidate;
        let format = if is_loading {
            None
        } else if candidate.quality.is_some() {
            choice.preferred()
        } else {
            joins(i, &choices, &layers).then_some(FrameBufferFormat::Rg11b10Ufloat)
        };
        let mut entity = commands.entity(candidate.entity);
        views.remove(&candidate.entity);
        match format {
            Some(FrameBufferFormat::Packed(_)) => {
                let quality = candidate.quality.copied().unwrap_or_default();
                let settings = quality.packed_settings();
                // Formats without support were refused above.
                if let Ok(resolve) = conditions.support(candidate, settings.format.into()) {
                    let view = PackedView::new(candidate, settings, resolve);
                    entity.remove::<Rg11b10UfloatView>().insert(view);
                }
            }
            Some(FrameBufferFormat::Rg11b10Ufloat) => {
                entity
                    .remove::<PackedComponents>()
                    .insert(Rg11b10UfloatView);
            }
            None => {
                entity.remove::<(PackedComponents, Rg11b10UfloatView)>();
            }
        }
        if !is_loading {
            formats.insert(candidate.entity, format);
        }
        if candidate.quality.is_some() {
            let state = match (format, choice.refused.last()) {
                _ if is_loading => CameraState::Pending,
                (Some(FrameBufferFormat::Packed(format)), _) => CameraState::Packed(format),
                (Some(FrameBufferFormat::Rg11b10Ufloat), _) => CameraState::Rg11b10Ufloat,
                (None, Some(refused)) => CameraState::Fallback(refused.reason.clone()),
                (None, None) => CameraState::Exact,
            };
            let refused = if is_loading {
                Vec::new()
            } else {
                choice.refused.clone()
            };
            let main_entity = candidate.main_entity.id();
            decisions.0.insert(main_entity, (state, refused));
        }
    }
    // Those that are not drawn in this frame.
    for entity in views {
        commands
            .entity(entity)
            .remove::<(PackedComponents, Rg11b10UfloatView)>();
    }
    switched.views = formats
        .iter()
        .filter(|&(view, format)| switched.previous.get(view).is_some_and(|f| f != format))
        .map(|(&view, _)| view)
        .collect();
    switched.previous = formats;
}

/// Returns the formats that the cameras can use, by themselves and beside each other.
fn choose_formats<'a, 'w, 's>(
    cameras: &'a [CandidateItem<'w, 's>],
    layers: &[Layer],
    conditions: &Conditions,
    refusals: &Refusals,
) -> Vec<Choice<'a, 'w, 's>> {
    let mut choices: Vec<_> = cameras
        .iter()
        .map(|candidate| {
            let quality = candidate.quality.copied().unwrap_or_default();
            let mut choice = Choice {
                candidate,
                remaining: if draws_colors(candidate.camera) {
                    quality.formats(candidate.camera.hdr)
                } else {
                    Vec::new()
                },
                refused: Vec::new(),
            };
            choice.refuse_impossible(conditions, refusals);
            choice
        })
        .collect();
    // What one camera cannot use may leave another without company, until all of them agree.
    loop {
        let failing: Vec<_> = (0..choices.len())
            .filter_map(|i| {
                let reason = stack_reason(i, &choices, layers, conditions, refusals)?;
                Some((i, reason))
            })
            .collect();
        if failing.is_empty() {
            break;
        }
        for (i, reason) in failing {
            choices[i].refuse(reason);
            choices[i].refuse_impossible(conditions, refusals);
        }
    }
    choices
}

impl Conditions<'_, '_> {
    /// Returns the first reason for which the camera alone cannot use the format.
    fn reason(
        &self,
        candidate: &CandidateItem,
        format: FrameBufferFormat,
        refusals: &Refusals,
    ) -> Option<FallbackReason> {
        // A camera without a quality only joins others, and may be one of two dimensions.
        let joins = candidate.quality.is_none() && candidate.is_2d();
        if !candidate.is_3d() && !joins {
            return Some(FallbackReason::Not3d);
        }
        if candidate.is_transparent(&self.clear_color) {
            return Some(FallbackReason::TransparentBackground);
        }
        let reason = match format {
            FrameBufferFormat::Packed(format) => {
                packed_reason(candidate, format, &self.state, self.systems.foreign())
            }
            FrameBufferFormat::Rg11b10Ufloat => rg11b10ufloat_reason(candidate, &self.views),
        };
        reason
            .or_else(|| candidate.atmosphere.then_some(FallbackReason::Atmosphere))
            .or_else(|| refusals.get(candidate.main_entity.id(), format))
            .or_else(|| self.support(candidate, format).err())
    }

    /// Whether the hardware can resolve the camera's samples in the format, if it supports that.
    fn support(
        &self,
        candidate: &CandidateItem,
        format: FrameBufferFormat,
    ) -> Result<bool, FallbackReason> {
        let features = format_features(format.texture_format(), &self.adapter, &self.device);
        hardware_resolve(format, candidate.msaa.samples(), features)
    }
}

/// Returns the first reason for which the camera alone cannot pack.
fn packed_reason(
    candidate: &CandidateItem,
    format: PackedFormat,
    state: &MainWorldState,
    main_pass_system: Option<&str>,
) -> Option<FallbackReason> {
    // The cause precedes its consequences: screen-space reflections require the deferred prepass.
    use FallbackReason as Reason;
    if let Some(error) = &state.refused {
        return Some(Reason::PatchRefused(error.clone()));
    }
    let is_unorm8 = format == PackedFormat::Unorm8;
    let reasons = [
        (candidate.reflections, Reason::ScreenSpaceReflections),
        (candidate.deferred, Reason::DeferredPrepass),
        (candidate.transparency, Reason::OrderIndependentTransparency),
        (state.wireframes, Reason::Wireframes),
        (candidate.resolution_override, Reason::ResolutionOverride),
        (candidate.has_no_clear(), Reason::NoClear),
        (is_unorm8 && candidate.camera.hdr, Reason::Unorm8WithHdr),
    ];
    let reason = reasons.into_iter().find(|(applies, _)| *applies);
    let system = main_pass_system.map(|name| Reason::MainPassSystem(name.into()));
    reason.map(|(_, reason)| reason).or(system)
}

/// The last of the subviews of a camera that take their format from its own: that of Bevy's user interface.
const LAST_SUBVIEW: u32 = 1;

/// Returns the first reason for which the camera alone cannot be drawn in `Rg11b10Ufloat`.
fn rg11b10ufloat_reason(
    candidate: &CandidateItem,
    views: &Query<&ExtractedView>,
) -> Option<FallbackReason> {
    let drawn_over = views.iter().any(|view| {
        view.retained_view_entity.main_entity == *candidate.main_entity
            && view.retained_view_entity.subview_index > LAST_SUBVIEW
    });
    let has_storage = candidate.usages.0.contains(TextureUsages::STORAGE_BINDING);
    let drawn_over = drawn_over.then_some(FallbackReason::DrawnOver);
    drawn_over.or(has_storage.then_some(FallbackReason::StorageUsage))
}

/// Returns the reason for which a camera cannot use the format that it prefers beside the other cameras.
fn stack_reason(
    index: usize,
    choices: &[Choice],
    layers: &[Layer],
    conditions: &Conditions,
    refusals: &Refusals,
) -> Option<FallbackReason> {
    let layer = &layers[index];
    match choices[index].preferred()? {
        FrameBufferFormat::Packed(_) => packed_stack_reason(layer, layers),
        format @ FrameBufferFormat::Rg11b10Ufloat => {
            if is_continued(layers.iter().filter(|other| other.shares(layer))) {
                for (choice, other) in choices.iter().zip(layers) {
                    if other.shares(layer)
                        && choice.preferred() != Some(format)
                        && let Some(why) = cannot_join(choice, conditions, refusals)
                    {
                        return Some(FallbackReason::ContinuedInAnotherFormat(why));
                    }
                }
            }
            // Cameras with and without `Hdr`, which Bevy keeps apart, would share their textures.
            let mut of_the_format = choices.iter().zip(layers).filter(|(choice, other)| {
                other.could_share(layer) && choice.preferred() == Some(format)
            });
            let would_share = of_the_format.clone().map(|(_, other)| other);
            (of_the_format.any(|(_, other)| other.format != layer.format)
                && is_continued(would_share))
            .then(|| {
                let why = "One of them has `Hdr` and the other has not.".into();
                FallbackReason::ContinuedInAnotherFormat(why)
            })
        }
    }
}

/// Returns why a camera that does not prefer `Rg11b10Ufloat` cannot take it from one that does.
fn cannot_join(choice: &Choice, conditions: &Conditions, refusals: &Refusals) -> Option<String> {
    match (
        choice.candidate.quality,
        choice.preferred(),
        choice.refused.last(),
    ) {
        (None, ..) => conditions
            .reason(choice.candidate, FrameBufferFormat::Rg11b10Ufloat, refusals)
            .map(|reason| format!("It cannot: {reason}")),
        (Some(FrameBufferQuality::Exact), ..) => Some("It has `Exact`.".into()),
        (_, Some(_), _) => Some("It is packed.".into()),
        (_, None, Some(refused)) => Some(format!("It cannot: {}", refused.reason)),
        (_, None, None) => Some(String::new()),
    }
}

/// Whether a camera without a quality of its own shares the picture of one in `Rg11b10Ufloat`.
fn joins(index: usize, choices: &[Choice], layers: &[Layer]) -> bool {
    let layer = &layers[index];
    let small_floats = Some(FrameBufferFormat::Rg11b10Ufloat);
    let mut choices = choices.iter().zip(layers);
    choices.any(|(choice, other)| other.shares(layer) && choice.preferred() == small_floats)
        && is_continued(layers.iter().filter(|other| other.shares(layer)))
}

/// What decides with which cameras of its target a camera shares its picture.
///
/// Bevy draws cameras of the same target, format, usages and samples into the same textures. A camera that does not
/// clear them continues the picture that is in them, and so does a multisampled one to which Bevy's MSAA writeback
/// gives it, as it does to the second of two cameras that fill their target. Such cameras must have one format.
#[derive(Clone, Debug, PartialEq)]
struct Layer {
    entity: Entity,
    target: Option<NormalizedRenderTarget>,
    usages: TextureUsages,
    format: TextureFormat,
    samples: u32,
    order: isize,
    has_viewport: bool,
    has_no_clear: bool,
    writeback: MsaaWriteback,
}

impl Layer {
    fn of(candidate: &CandidateItem) -> Self {
        Self {
            entity: candidate.entity,
            target: candidate.camera.target.clone(),
            usages: candidate.usages.0,
            format: candidate.view.target_format,
            samples: candidate.msaa.samples(),
            order: candidate.camera.order,
            has_viewport: candidate.camera.viewport.is_some(),
            has_no_clear: candidate.has_no_clear(),
            writeback: candidate.camera.msaa_writeback,
        }
    }

    /// Whether both have the same textures, if their formats are the same.
    fn could_share(&self, other: &Self) -> bool {
        self.target == other.target && self.usages == other.usages && self.samples == other.samples
    }

    /// Whether Bevy draws both into the same textures.
    fn shares(&self, other: &Self) -> bool {
        self.could_share(other) && self.format == other.format
    }

    /// Whether the camera continues the picture in its textures, if those of `others` have the same. Bevy leaves the
    /// order of cameras of the same order open, so that either may be the first.
    fn continues<'a>(&self, mut others: impl Iterator<Item = &'a Self>) -> bool {
        let is_written_back = match self.writeback {
            MsaaWriteback::Off => false,
            MsaaWriteback::Always => true,
            MsaaWriteback::Auto => {
                !self.has_viewport
                    && others.any(|other| other.entity != self.entity && other.order <= self.order)
            }
        };
        self.has_no_clear || (self.samples > 1 && is_written_back)
    }
}

/// Whether any of these cameras, which have the same textures, continues a picture.
fn is_continued<'a>(members: impl Iterator<Item = &'a Layer> + Clone) -> bool {
    members
        .clone()
        .any(|member| member.continues(members.clone()))
}

/// Returns the reason for which the camera cannot pack beside the other cameras of its target.
///
/// A packed camera writes a single-sampled `ViewTarget`, in which no later camera finds samples.
fn packed_stack_reason(layer: &Layer, layers: &[Layer]) -> Option<FallbackReason> {
    let sharing = layers.iter().filter(|other| other.shares(layer));
    if layer.continues(sharing.clone()) {
        return Some(FallbackReason::MsaaWriteback);
    }
    let is_multisampled = layer.samples > 1;
    // A single-sampled camera that does not clear would find the picture of this one instead of its own.
    let would_be_continued = layers.iter().any(|other| {
        let single_sampled = Layer {
            samples: other.samples,
            ..layer.clone()
        };
        other.samples == 1 && other.has_no_clear && other.shares(&single_sampled)
    });
    (is_multisampled && (is_continued(sharing) || would_be_continued))
        .then_some(FallbackReason::ContinuedByMultisampled)
}

/// Publishes the reports on all cameras with a quality, with the memory of their colour textures as allocated.
pub(super) fn publish_reports(
    views: Query<(
        &MainEntity,
        &ExtractedCamera,
        Option<&ViewTarget>,
        Option<&PackedTextures>,
    )>,
    mut decisions: ResMut<Decisions>,
    reports: Res<RenderedReports>,
    adapter: Res<RenderAdapterInfo>,
) {
    if decisions.0.is_empty() {
        return;
    }
    let is_free = |texture: &Texture| {
        let usage = texture.usage();
        adapter.transient_saves_memory == Some(true)
            && usage.contains(TextureUsages::TRANSIENT_ATTACHMENT)
    };
    let packed_bytes =
        |texture: Option<&CachedTexture>| match texture.map(|texture| &texture.texture) {
            Some(texture) if !is_free(texture) => bytes(texture),
            _ => 0,
        };
    let mut rendered = EntityHashMap::default();
    for (main_entity, camera, target, packed) in &views {
        // The window is not there yet.
        if target.is_none() && draws_colors(camera) {
            continue;
        }
        if let Some((state, refused)) = decisions.0.remove(&main_entity.id()) {
            let memory = ColorMemory {
                packed: packed_bytes(packed.and_then(|p| p.single_sampled.as_ref())),
                packed_multisampled: packed_bytes(packed.and_then(|p| p.multisampled.as_ref())),
                main: target.map_or(0, |t| {
                    bytes(t.main_texture()) + bytes(t.main_texture_other())
                }),
                main_multisampled: target
                    .and_then(ViewTarget::sampled_main_texture)
                    .map_or(0, bytes),
            };
            let report = FrameBufferReport {
                state,
                refused,
                memory,
            };
            rendered.insert(main_entity.id(), report);
        }
    }
    reports.publish(rendered);
}

fn bytes(texture: &Texture) -> u64 {
    let size = texture.size();
    let texels = u64::from(size.width) * u64::from(size.height) * u64::from(texture.sample_count());
    let texel_bytes = texture.format().block_copy_size(None).unwrap_or(0);
    texels * u64::from(texel_bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layer(index: u32, order: isize, samples: u32) -> Layer {
        Layer {
            entity: Entity::from_raw_u32(index).expect("an index"),
            target: None,
            usages: TextureUsages::RENDER_ATTACHMENT,
            format: TextureFormat::Rgba16Float,
            samples,
            order,
            has_viewport: false,
            has_no_clear: false,
            writeback: MsaaWriteback::Auto,
        }
    }

    #[test]
    fn the_later_of_two_multisampled_cameras_continues_unless_it_has_a_viewport() {
        for (samples, has_viewport, writeback, expected) in [
            (4, false, MsaaWriteback::Auto, true),
            (4, true, MsaaWriteback::Auto, false),
            (4, true, MsaaWriteback::Always, true),
            (4, false, MsaaWriteback::Off, false),
            (1, false, MsaaWriteback::Auto, false),
            (1, false, MsaaWriteback::Always, false),
        ] {
            let below = layer(1, 0, samples);
            let above = Layer {
                has_viewport,
                writeback,
                ..layer(2, 1, samples)
            };
            let both = [below, above];
            assert!(!both[0].continues(both.iter()));
            assert_eq!(both[1].continues(both.iter()), expected, "{:?}", both[1]);
        }
    }

    #[test]
    fn a_camera_without_clear_colour_continues() {
        let alone = Layer {
            has_no_clear: true,
            ..layer(1, 0, 1)
        };
        assert!(is_continued([alone].iter()));
        assert!(!is_continued([layer(1, 0, 4)].iter()));
    }

    #[test]
    fn cameras_of_other_formats_or_samples_share_nothing() {
        let hdr = layer(1, 0, 4);
        let ldr = Layer {
            format: TextureFormat::Rgba8UnormSrgb,
            ..layer(2, 1, 4)
        };
        assert!(!hdr.shares(&ldr) && hdr.could_share(&ldr));
        assert!(!hdr.could_share(&layer(2, 1, 1)));
        assert!(hdr.shares(&layer(2, 1, 4)));
    }
}
