//! A live map of the error between the two pictures: for scenes with the settings `view` and `error_gain`.

use bevy::{
    asset::{AssetPath, embedded_asset, embedded_path},
    camera::{ImageRenderTarget, RenderTarget, visibility::RenderLayers},
    core_pipeline::tonemapping::DebandDither,
    prelude::*,
    render::render_resource::{AsBindGroup, TextureFormat},
    shader::ShaderRef,
    sprite_render::{Material2d, Material2dPlugin},
};

use crate::{
    headless::LabTarget,
    runner::{PictureArea, SceneSetting, SceneSettings, Side, SplitLine},
    scenes::{QUAD_LAYER, quad_camera},
};

/// The systems in `Update` that open and close the view; what configures its cameras comes after.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ErrorViewSystems;

pub fn view_setting() -> SceneSetting {
    SceneSetting::choice(
        "view",
        "the picture, or a live map of the absolute error between the two pictures, from black to pale yellow",
        0,
        &["picture", "error"],
    )
}

pub fn gain_setting() -> SceneSetting {
    SceneSetting::integer(
        "error_gain",
        "error times this: pale yellow is 255 levels divided by it",
        8,
        1..=32,
        "",
    )
}

/// Adds the view to a scene that has both settings.
pub struct ErrorViewPlugin;

impl Plugin for ErrorViewPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(Material2dPlugin::<ErrorMaterial>::default());
        embed(app);
        app.init_resource::<ErrorView>()
            .add_systems(
                Update,
                (open_or_close, hide_split).chain().in_set(ErrorViewSystems),
            )
            .add_systems(PostUpdate, follow_pose.before(TransformSystems::Propagate));
    }
}

/// The largest difference of a channel of two pictures in sRGB, times a gain, in the colours of
/// [`absolute_error_heat_map`](crate::metrics::heat_map::absolute_error_heat_map).
#[derive(Asset, TypePath, AsBindGroup, Clone, Debug)]
pub struct ErrorMaterial {
    /// The picture without the plugin.
    #[texture(0)]
    pub before: Handle<Image>,
    /// That with it, of the same size.
    #[texture(1)]
    pub after: Handle<Image>,
    /// Pale yellow is a difference of `1 / gain` of the full range. 1 or more.
    #[uniform(2)]
    pub gain: f32,
}

impl Material2d for ErrorMaterial {
    fn fragment_shader() -> ShaderRef {
        ShaderRef::Path(AssetPath::from(embedded_path!("error.wesl")).with_source("embedded"))
    }
}

/// Puts the shader into the binary.
pub fn embed(app: &mut App) {
    embedded_asset!(app, "error.wesl");
}

// Two cameras off screen and a quad over the picture area that shows their difference.
//
// They exist only while the view is open.

/// The part of the target that the open view fills; none when it is closed.
#[derive(Resource, Default)]
pub struct ErrorView(Option<URect>);

/// A camera that shows a side: that of the split (if the scene says so), or one off screen.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct Films(pub Side);

#[derive(Component)]
pub struct OfView;

/// A camera of the view that films the scene.
#[derive(Component)]
pub struct OffScreen;

/// Opens or closes the view, opens it again at another size, and sets its gain.
pub fn open_or_close(
    mut commands: Commands,
    settings: Res<SceneSettings>,
    area: Res<PictureArea>,
    target: Res<LabTarget>,
    mut view: ResMut<ErrorView>,
    mut images: ResMut<Assets<Image>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<ErrorMaterial>>,
    split: Query<(&Side, &Projection, &Transform), With<Camera>>,
    parts: Query<Entity, With<OfView>>,
) {
    let requested = (settings.choice("view") == "error" && !area.0.is_empty()).then_some(area.0);
    let gain = settings.integer("error_gain") as f32;
    if view.0 == requested {
        if settings.is_changed() {
            for (_, material) in materials.iter_mut() {
                material.gain = gain;
            }
        }
        return;
    }
    view.0 = requested;
    for part in &parts {
        commands.entity(part).despawn();
    }
    let before = split.iter().find(|(side, ..)| **side == Side::Before);
    let (Some(area), Some((_, projection, pose))) = (requested, before) else {
        return;
    };
    let size = area.size();
    let [before, after] = Side::BOTH.map(|side| {
        let format = TextureFormat::Rgba8UnormSrgb;
        let image = images.add(Image::new_target_texture(size.x, size.y, format, None));
        let order = match side {
            Side::Before => -2,
            Side::After => -1,
        };
        commands.spawn((
            OfView,
            OffScreen,
            Films(side),
            Camera3d::default(),
            Camera { order, ..default() },
            RenderTarget::Image(ImageRenderTarget::from(image.clone())),
            side.layers().with(0),
            DebandDither::Disabled,
            projection.clone(),
            *pose,
        ));
        image
    });
    commands.spawn((
        OfView,
        Mesh2d(meshes.add(Rectangle::from_length(1.0))),
        MeshMaterial2d(materials.add(ErrorMaterial {
            before,
            after,
            gain,
        })),
        RenderLayers::layer(QUAD_LAYER),
    ));
    commands.spawn((OfView, quad_camera(area, &target)));
}

/// The cameras at the split see nothing while the view covers them; they still exist for the
/// reports on their memory.
pub fn hide_split(
    mut commands: Commands,
    view: Res<ErrorView>,
    mut line: ResMut<SplitLine>,
    cameras: Query<(Entity, &Side), With<Camera>>,
) {
    if !view.is_changed() {
        return;
    }
    let is_open = view.0.is_some();
    line.set_if_neq(SplitLine(!is_open));
    for (camera, side) in &cameras {
        let layers = if is_open {
            RenderLayers::none()
        } else {
            side.layers().with(0)
        };
        commands.entity(camera).insert(layers);
    }
}

/// The cameras off screen go where the "before" camera is, as that one is steered.
pub fn follow_pose(
    split: Query<(&Side, &Transform), (With<Camera>, Without<OffScreen>)>,
    mut off_screen: Query<&mut Transform, With<OffScreen>>,
) {
    let Some((_, pose)) = split.iter().find(|(side, _)| **side == Side::Before) else {
        return;
    };
    for mut transform in &mut off_screen {
        transform.set_if_neq(*pose);
    }
}
