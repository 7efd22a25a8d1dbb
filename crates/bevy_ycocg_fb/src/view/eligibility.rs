//! The choice of the cameras that use another format.

use bevy::{
    ecs::{
        entity::{EntityHashMap, EntityHashSet},
        system::SystemParam,
    },
    prelude::*,
    render::{
        render_resource::TextureUsages,
        renderer::{RenderAdapter, RenderDevice},
        view::ExtractedView,
    },
};

use super::{
    conditions::{
        Candidate, CandidateItem, FormatSupport, MainPassSystems, MainWorldState, draws_colors,
    },
    formatted::{Formatted, PackedView, Rg11b10UfloatView},
    refusals::Refusals,
    stack::{Layer, is_continued, packed_stack_reason},
};
use crate::{
    material::detect::PackingShaders,
    report::{CameraState, FallbackReason, RefusedFormat},
    settings::{FrameBufferFormat, FrameBufferQuality, PackedFormat},
};

/// What was chosen in this frame, by camera in the main world.
#[derive(Resource, Debug, Default)]
pub(super) struct Decisions(pub EntityHashMap<(CameraState, Vec<RefusedFormat>)>);

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
                let settings = candidate
                    .quality
                    .copied()
                    .unwrap_or_default()
                    .packed_settings();
                // Formats without support were refused above.
                if let Ok(support) = conditions.support(candidate, settings.format.into()) {
                    let view = PackedView::new(candidate, settings, support);
                    entity.remove::<Rg11b10UfloatView>().insert(view);
                }
            }
            Some(FrameBufferFormat::Rg11b10Ufloat) => {
                entity.remove::<PackedView>().insert(Rg11b10UfloatView);
            }
            None => {
                entity.remove::<(PackedView, Rg11b10UfloatView)>();
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
            .remove::<(PackedView, Rg11b10UfloatView)>();
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

    fn support(
        &self,
        candidate: &CandidateItem,
        format: FrameBufferFormat,
    ) -> Result<FormatSupport, FallbackReason> {
        FormatSupport::of(
            format,
            candidate.msaa.samples(),
            &self.adapter,
            &self.device,
        )
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
    let reasons = [
        state.refused.clone().map(FallbackReason::PatchRefused),
        candidate
            .reflections
            .then_some(FallbackReason::ScreenSpaceReflections),
        candidate
            .deferred
            .then_some(FallbackReason::DeferredPrepass),
        candidate
            .transparency
            .then_some(FallbackReason::OrderIndependentTransparency),
        state.wireframes.then_some(FallbackReason::Wireframes),
        candidate
            .resolution_override
            .then_some(FallbackReason::ResolutionOverride),
        candidate.has_no_clear().then_some(FallbackReason::NoClear),
        (format == PackedFormat::Unorm8 && candidate.camera.hdr)
            .then_some(FallbackReason::Unorm8WithHdr),
        main_pass_system.map(|name| FallbackReason::MainPassSystem(name.into())),
    ];
    reasons.into_iter().flatten().next()
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
    if drawn_over {
        Some(FallbackReason::DrawnOver)
    } else if has_storage {
        Some(FallbackReason::StorageUsage)
    } else {
        None
    }
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
    let sharing = layers.iter().filter(|other| other.shares(layer));
    let mut choices_of_picture = choices.iter().zip(layers).filter(|(_, o)| o.shares(layer));
    choices_of_picture
        .any(|(choice, _)| choice.preferred() == Some(FrameBufferFormat::Rg11b10Ufloat))
        && is_continued(sharing)
}
