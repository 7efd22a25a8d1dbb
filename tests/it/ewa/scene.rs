//! A floor whose material can be changed between pictures.

use bevy::{
    asset::RenderAssetUsages,
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    image::{ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor},
    mesh::{Indices, PrimitiveTopology},
    pbr::ScreenSpaceTransmission,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_ewa::{
    AllMaterials, EwaMethod, EwaOverrides, EwaPlugin, EwaReport, EwaSettings, EwaStandardMaterial,
    MipReport,
    mips::{self, texel::Storage},
};
use bevy_frugal_lab::headless::{HeadlessApp, HeadlessSettings, LabTarget};
use image::RgbImage;

use crate::support::pool::{Borrowed, Pool};

static STOCK: Pool = Pool::new(|| build(small(), None), begin);
static FILTERED: Pool = Pool::new(|| build(small(), Some(EwaPlugin::OPT_IN)), begin);

/// A headless app with a floor, a post with an alpha mask, a sun with shadows, and one camera.
pub struct Floor {
    pub app: Borrowed,
    pub camera: Entity,
    pub floor: Entity,
    pub post: Entity,
    pub material: Handle<StandardMaterial>,
}

impl Floor {
    /// The scene with or without the plugin. The material is made of an image without mips if not
    /// `mipped`.
    pub fn new(
        plugin: Option<EwaPlugin>,
        material: impl FnOnce(&mut Assets<Image>) -> StandardMaterial,
    ) -> Self {
        let app = match plugin {
            None => STOCK.app(),
            Some(plugin) => {
                let mut app = FILTERED.app();
                app.world_mut()
                    .insert_resource(AllMaterials(plugin.all_materials));
                app
            }
        };
        Self::in_app(app, material)
    }

    /// The scene with all materials filtered by a method.
    pub fn filtered(
        method: EwaMethod,
        material: impl FnOnce(&mut Assets<Image>) -> StandardMaterial,
    ) -> Self {
        Self::new(all(EwaSettings::with_method(method)), material)
    }

    /// The scene in an app of its own.
    pub fn with_settings(
        settings: HeadlessSettings,
        plugin: Option<EwaPlugin>,
        material: impl FnOnce(&mut Assets<Image>) -> StandardMaterial,
    ) -> Self {
        Self::in_app(build(settings, plugin).into(), material)
    }

    /// The scene in an app with other plugins.
    pub fn with_plugins(settings: HeadlessSettings, plugins: impl FnOnce(&mut App)) -> Self {
        let app = HeadlessApp::new(settings, plugins).expect("a headless app");
        Self::in_app(app.into(), |_| StandardMaterial::default())
    }

    fn in_app(
        mut app: Borrowed,
        material: impl FnOnce(&mut Assets<Image>) -> StandardMaterial,
    ) -> Self {
        let world = app.world_mut();
        let target = world.resource::<LabTarget>().0.clone();
        let camera = world
            .spawn((
                Camera3d::default(),
                target,
                Tonemapping::None,
                DebandDither::Disabled,
                Msaa::Off,
                ScreenSpaceTransmission::default(),
                Transform::from_xyz(0.0, 0.6, 0.0).looking_at(Vec3::new(1.0, 0.4, -5.0), Vec3::Y),
            ))
            .id();
        world.spawn((
            DirectionalLight {
                illuminance: 8000.0,
                shadow_maps_enabled: true,
                ..default()
            },
            Transform::from_xyz(-3.0, 5.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y),
        ));
        let mut images = world.resource_mut::<Assets<Image>>();
        let standard = material(&mut images);
        let mask = images.add(texture(true, TextureFormat::Rgba8UnormSrgb, |x, y| {
            [255, 150, 80, if (x / 8 + y / 8) % 2 == 0 { 255 } else { 0 }]
        }));
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        let material = materials.add(standard);
        let post = materials.add(StandardMaterial {
            base_color_texture: Some(mask),
            alpha_mode: AlphaMode::Mask(0.5),
            cull_mode: None,
            ..default()
        });
        let mut meshes = world.resource_mut::<Assets<Mesh>>();
        let plane = meshes.add(plane());
        let cube = meshes.add(Cuboid::from_length(0.4));
        let post = world.spawn((
            Mesh3d(cube),
            MeshMaterial3d(post),
            Transform::from_xyz(0.5, 0.3, -1.5).with_rotation(Quat::from_rotation_y(0.9)),
        ));
        let post = post.id();
        let floor = world
            .spawn((Mesh3d(plane), MeshMaterial3d(material.clone())))
            .id();
        app.run_until_ready(300).expect("the scene is ready");
        Self {
            app,
            camera,
            floor,
            post,
            material,
        }
    }

    /// Filters all `StandardMaterial`s so.
    pub fn all(&mut self, settings: Option<EwaSettings>) -> RgbImage {
        self.app.world_mut().insert_resource(AllMaterials(settings));
        self.picture()
    }

    /// Gives the floor a material of its own kind.
    pub fn chosen(&mut self, settings: EwaSettings) -> RgbImage {
        let world = self.app.world_mut();
        let base = world.resource::<Assets<StandardMaterial>>();
        let base = base.get(&self.material).expect("the material").clone();
        let material = world.add_asset::<EwaStandardMaterial>(EwaStandardMaterial {
            base,
            extension: settings.into(),
        });
        world
            .entity_mut(self.floor)
            .remove::<MeshMaterial3d<StandardMaterial>>()
            .insert(MeshMaterial3d(material));
        self.picture()
    }

    /// Gives the floor another material of Bevy's own kind.
    pub fn lay(&mut self, material: impl FnOnce(&mut Assets<Image>) -> StandardMaterial) {
        let world = self.app.world_mut();
        let new = material(&mut world.resource_mut::<Assets<Image>>());
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        if let Some(mut old) = materials.get_mut(&self.material) {
            *old = new;
        }
    }

    /// Takes the post away.
    pub fn clear(&mut self) {
        let world = self.app.world_mut();
        world.entity_mut(self.post).despawn();
    }

    pub fn picture(&mut self) -> RgbImage {
        self.app.run_until_ready(300).expect("ready");
        self.app.render_frames(2).expect("frames");
        self.app.capture_rgb8().expect("a picture")
    }
}

/// The plugin, with all materials filtered like this.
pub fn all(settings: EwaSettings) -> Option<EwaPlugin> {
    Some(EwaPlugin {
        all_materials: Some(settings),
    })
}

fn small() -> HeadlessSettings {
    HeadlessSettings::with_size(96, 64)
}

fn build(settings: HeadlessSettings, plugin: Option<EwaPlugin>) -> HeadlessApp {
    HeadlessApp::new(settings, |app| {
        if let Some(plugin) = plugin {
            app.add_plugins(plugin);
        }
    })
    .expect("a headless app")
}

/// What tests may have changed beside their entities.
fn begin(world: &mut World) {
    world.insert_resource(GlobalAmbientLight::default());
    world.insert_resource(ClearColor::default());
    if world.contains_resource::<EwaOverrides>() {
        world.insert_resource(EwaOverrides::default());
    }
}

/// The mip levels that an image has got.
pub fn mips(world: &World, image: &Handle<Image>) -> Option<MipReport> {
    let report = world.resource::<EwaReport>();
    Some(report.textures.get(&image.id())?.mips)
}

/// 64 x 64 texels, repeating, with mips or without.
pub fn texture(mipped: bool, format: TextureFormat, texel: impl Fn(u32, u32) -> [u8; 4]) -> Image {
    const SIZE: u32 = 64;
    let data = (0..SIZE * SIZE)
        .flat_map(|i| texel(i % SIZE, i / SIZE))
        .collect();
    let texels = mips::TexelFormat {
        channels: 4,
        storage: Storage::Unorm8,
        srgb: format.is_srgb(),
    };
    let mut image = Image::new(
        Extent3d {
            width: SIZE,
            height: SIZE,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        data,
        format,
        RenderAssetUsages::default(),
    );
    if mipped {
        let chain = mips::generate_mip_chain(
            [SIZE; 2],
            texels,
            image.data.take().expect("data"),
            default(),
        );
        let chain = chain.expect("a chain");
        image.data = Some(chain.data);
        image.texture_descriptor.mip_level_count = chain.levels;
    }
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        mipmap_filter: ImageFilterMode::Linear,
        ..ImageSamplerDescriptor::linear()
    });
    image
}

/// Checks of these two texels.
pub fn checks(a: [u8; 4], b: [u8; 4]) -> impl Fn(u32, u32) -> [u8; 4] {
    move |x, y| if (x / 8 + y / 8) % 2 == 0 { a } else { b }
}

/// A base colour of checks.
pub fn checkered(mipped: bool) -> impl FnOnce(&mut Assets<Image>) -> StandardMaterial {
    move |images| StandardMaterial {
        base_color_texture: Some(images.add(texture(
            mipped,
            TextureFormat::Rgba8UnormSrgb,
            checks([250, 250, 240, 255], [20, 30, 60, 255]),
        ))),
        ..default()
    }
}

/// A large plane with two different sets of texture coordinates, and tangents.
fn plane() -> Mesh {
    let half = 60.0f32;
    let corners = [[-half, -half], [-half, half], [half, half], [half, -half]];
    let positions = corners.map(|[x, z]| [x, 0.0, z]);
    Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::default(),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions.to_vec())
    .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 1.0, 0.0]; 4])
    .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, corners.to_vec())
    .with_inserted_attribute(
        Mesh::ATTRIBUTE_UV_1,
        corners
            .map(|[x, z]| [0.7 * x - 0.7 * z, 0.7 * x + 0.7 * z])
            .to_vec(),
    )
    .with_inserted_indices(Indices::U32(vec![0, 1, 2, 0, 2, 3]))
    .with_generated_tangents()
    .expect("tangents")
}
