//! Elliptical filtering on the GPU: a floor whose material can be changed between pictures.

mod exact;
mod games;
mod materials;
mod mips;
mod pipelines;
mod textures;

use bevy::{
    asset::RenderAssetUsages,
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    image::{ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor, ToExtents},
    mesh::{Indices, PrimitiveTopology},
    pbr::ScreenSpaceTransmission,
    prelude::*,
    render::{
        RenderApp,
        render_resource::{CachedPipeline, PipelineCache, TextureDimension, TextureFormat},
    },
};
use bevy_ewa::{
    AllMaterials, EwaMethod, EwaOverrides, EwaPlugin, EwaProbes, EwaReport, EwaSettings,
    EwaStandardMaterial, MipReport,
    mips::{TexelFormat, generate_mip_chain, texel::Storage},
};
use bevy_frugal_lab::headless::{HeadlessApp, HeadlessSettings, LabTarget};
use image::RgbImage;

use crate::support::pool::{Borrowed, Pool};

static STOCK: Pool = Pool::new(|| build(small(), None), begin);
static FILTERED: Pool = Pool::new(|| build(small(), Some(EwaPlugin::OPT_IN)), begin);

pub const APPROXIMATE: EwaMethod = EwaMethod::Approximate {
    probes: EwaProbes::Five,
};

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

    /// The pipelines of the app.
    pub fn pipelines(&mut self) -> Vec<&CachedPipeline> {
        let render_app = self.app.app_mut().sub_app(RenderApp);
        let cache = render_app.world().resource::<PipelineCache>();
        cache.pipelines().collect()
    }

    /// The scene without its post.
    pub fn cleared(mut self) -> Self {
        let world = self.app.world_mut();
        world.entity_mut(self.post).despawn();
        self
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

/// A material of a base colour.
pub fn colored(texture: Handle<Image>) -> StandardMaterial {
    StandardMaterial {
        base_color_texture: Some(texture),
        ..default()
    }
}

/// A base colour that is shown as it is.
pub fn unlit(texture: Handle<Image>) -> StandardMaterial {
    StandardMaterial {
        unlit: true,
        ..colored(texture)
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
    let texels = TexelFormat {
        channels: 4,
        storage: Storage::Unorm8,
        srgb: format.is_srgb(),
    };
    let mut image = Image::new(
        UVec2::splat(SIZE).to_extents(),
        TextureDimension::D2,
        data,
        format,
        RenderAssetUsages::default(),
    );
    if mipped {
        let chain = generate_mip_chain(
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

/// Changes the sampler of a texture of [`texture`].
pub fn sampler(image: &mut Image) -> &mut ImageSamplerDescriptor {
    match &mut image.sampler {
        ImageSampler::Descriptor(sampler) => sampler,
        ImageSampler::Default => panic!("a sampler of its own"),
    }
}

/// Checks of these two texels.
pub fn checks(a: [u8; 4], b: [u8; 4]) -> impl Fn(u32, u32) -> [u8; 4] {
    move |x, y| if (x / 8 + y / 8) % 2 == 0 { a } else { b }
}

/// White and dark blue checks.
pub fn checked(mipped: bool) -> Image {
    let texels = checks([250, 250, 240, 255], [20, 30, 60, 255]);
    texture(mipped, TextureFormat::Rgba8UnormSrgb, texels)
}

/// A base colour of checks.
pub fn checkered(mipped: bool) -> impl FnOnce(&mut Assets<Image>) -> StandardMaterial {
    move |images| colored(images.add(checked(mipped)))
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
