//! A tunnel without end and a game's floor, filtered by one method on each side of the line.

use std::f32::consts::TAU;

use bevy::{
    asset::{AssetPath, RenderAssetUsages, embedded_asset, embedded_path},
    image::{ImageSampler, ImageSamplerDescriptor},
    math::Affine2,
    mesh::{Indices, MeshVertexBufferLayoutRef, PrimitiveTopology},
    pbr::{Material, MaterialPipeline, MaterialPipelineKey, MaterialPlugin},
    prelude::*,
    render::render_resource::{
        AsBindGroup, RenderPipelineDescriptor, SpecializedMeshPipelineError,
    },
    shader::ShaderRef,
};
use bevy_ewa::{
    EwaKernel, EwaLevelOfDetail, EwaMaps, EwaMethod, EwaPlugin, EwaProbes, EwaSettings,
    EwaStandardMaterial, EwaUniform,
};
use image::{Rgba, RgbaImage, buffer::ConvertBuffer};

use crate::{
    content,
    runner::{Choice, Scene, SceneSetting, SceneSettings, Side},
};

/// The example of `bevy_ewa`.
pub struct Ewa;

impl Scene for Ewa {
    fn name(&self) -> &'static str {
        "ewa"
    }

    fn plugin(&self) -> &'static str {
        "bevy_ewa"
    }

    fn description(&self) -> &'static str {
        "Texture filtering: a tunnel or a floor, by any method before and any after"
    }

    fn settings(&self) -> Vec<SceneSetting> {
        vec![
            PLACE.setting(),
            SceneSetting::choice(
                "view",
                "the picture; the ellipse of every 16th pixel in its texture; red where the \
                 anisotropy exceeds spatial_threshold",
                0,
                &["picture", "ellipses", "regions"],
            ),
            SceneSetting::choice(
                "before",
                "method left of the line; hardware is the sampler as it is, anisotropic with 16x",
                HARDWARE,
                &METHODS,
            ),
            SceneSetting::choice("after", "method right of the line", LINEAR, &METHODS),
            PROBES.setting(),
            SceneSetting::choice(
                "kernel",
                "of the exact methods",
                2,
                &["box", "tent", "gaussian", "mitchell_netravali", "lanczos"],
            ),
            SceneSetting::float(
                "sigma",
                "standard deviation of the Gaussian",
                0.5,
                0.2..=1.5,
                "pixels",
            ),
            SceneSetting::float(
                "max_anisotropy",
                "longest ellipse, in widths",
                32.0,
                1.0..=128.0,
                "",
            ),
            SceneSetting::float(
                "minor_radius",
                "least minor radius in the chosen mip level",
                1.5,
                0.5..=4.0,
                "texels",
            ),
            LEVEL_OF_DETAIL.setting(),
            SceneSetting::float(
                "level_blend",
                "part of the way to the next mip level in which both are blended",
                0.25,
                0.0..=1.0,
                "",
            ),
            SceneSetting::integer(
                "max_fetches",
                "most fetches of a lookup of the exact methods",
                2048,
                16..=4096,
                "",
            ),
            SceneSetting::float(
                "spatial_threshold",
                "anisotropy above which spatial works",
                16.0,
                2.0..=64.0,
                "",
            ),
            SceneSetting::integer(
                "sampler_anisotropy",
                "of the samplers: 1 computes probes, more leaves them to the texture unit",
                1,
                1..=16,
                "",
            ),
            SceneSetting::toggle("motion", "the texture drifts", true),
        ]
    }

    fn view(&self) -> Transform {
        Transform::from_xyz(0.0, 0.0, 0.0).looking_to(Vec3::new(0.12, -0.08, -1.0), Vec3::Y)
    }

    fn build(&self, app: &mut App) {
        embedded_asset!(app, "view.wesl");
        app.add_plugins((EwaPlugin::OPT_IN, MaterialPlugin::<ViewMaterial>::default()))
            .init_resource::<Textures>()
            .add_systems(Startup, spawn)
            .add_systems(
                Update,
                (
                    show_place,
                    configure.run_if(resource_changed::<SceneSettings>),
                    drift,
                )
                    .chain(),
            );
    }
}

/// The methods in the panel.
const METHODS: [&str; 11] = [
    "reference",
    "linear",
    "bilinear",
    "approximate",
    "spatial",
    "temporal",
    "spatial_temporal",
    "stochastic",
    "software_af16",
    "anisotropic",
    "hardware",
];
/// Index of Bevy's own.
const HARDWARE: usize = 10;
/// Index of the default.
const LINEAR: usize = 1;

static PLACE: Choice<Place, 2> = Choice::new(
    "place",
    "what there is to see",
    0,
    [("tunnel", Place::Tunnel), ("floor", Place::Floor)],
);
static PROBES: Choice<EwaProbes, 4> = Choice::new(
    "probes",
    "of the approximate, spatial and temporal methods",
    1,
    [
        ("3", EwaProbes::Three),
        ("5", EwaProbes::Five),
        ("7", EwaProbes::Seven),
        ("by_aspect", EwaProbes::ByAspect),
    ],
);
static LEVEL_OF_DETAIL: Choice<EwaLevelOfDetail, 2> = Choice::new(
    "level_of_detail",
    "what the mip level is chosen by",
    0,
    [
        ("minor_radius", EwaLevelOfDetail::MinorRadius),
        ("hardware", EwaLevelOfDetail::Hardware),
    ],
);

fn ewa_settings(settings: &SceneSettings, side: Side) -> EwaSettings {
    let probes = PROBES.of(settings);
    let method = match settings.choice(side.name()) {
        "reference" => EwaMethod::Reference,
        "linear" => EwaMethod::Linear,
        "bilinear" => EwaMethod::Bilinear,
        "approximate" => EwaMethod::Approximate { probes },
        "spatial" => EwaMethod::Spatial { probes },
        "temporal" => EwaMethod::Temporal { probes },
        "spatial_temporal" => EwaMethod::SpatialTemporal { probes },
        "stochastic" => EwaMethod::Stochastic,
        "software_af16" => EwaMethod::SoftwareAnisotropic,
        "anisotropic" => EwaMethod::Anisotropic,
        _ => EwaMethod::Hardware,
    };
    let kernel = match settings.choice("kernel") {
        "box" => EwaKernel::Box,
        "tent" => EwaKernel::Tent,
        "mitchell_netravali" => EwaKernel::MitchellNetravali,
        "lanczos" => EwaKernel::Lanczos,
        _ => EwaKernel::Gaussian {
            sigma_pixels: settings.float("sigma"),
        },
    };
    EwaSettings {
        method,
        maps: EwaMaps::default(),
        kernel,
        max_anisotropy: settings.float("max_anisotropy"),
        minor_radius_texels: settings.float("minor_radius"),
        level_of_detail: LEVEL_OF_DETAIL.of(settings),
        level_blend: settings.float("level_blend"),
        max_fetches: settings.integer("max_fetches"),
        spatial_threshold: settings.float("spatial_threshold"),
        sampler_anisotropy: settings.integer("sampler_anisotropy") as u16,
        periodic: true,
    }
}

#[derive(Asset, AsBindGroup, TypePath, Clone, Debug)]
struct ViewMaterial {
    #[uniform(0)]
    settings: EwaUniform,
    /// 0 for ellipses, 1 for regions.
    #[uniform(1)]
    view: Vec4,
    #[texture(2)]
    #[sampler(3)]
    texture: Handle<Image>,
}

impl ViewMaterial {
    fn new(view: &str, settings: &EwaSettings, texture: Handle<Image>) -> Self {
        let view = if view == "regions" { 1.0 } else { 0.0 };
        Self {
            settings: EwaUniform::new(settings),
            view: Vec4::splat(view),
            texture,
        }
    }
}

impl Material for ViewMaterial {
    fn fragment_shader() -> ShaderRef {
        ShaderRef::Path(AssetPath::from(embedded_path!("view.wesl")).with_source("embedded"))
    }

    fn specialize(
        _: &MaterialPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        _: &MeshVertexBufferLayoutRef,
        _: MaterialPipelineKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        descriptor.primitive.cull_mode = None;
        Ok(())
    }
}

/// Textures by which the surface drifts in a second.
const DRIFT: f32 = 0.1;

#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// A checkered tunnel, unlit.
    Tunnel,
    /// Bricks in the sun.
    Floor,
}

/// The textures, for each anisotropy of a sampler that was asked for.
#[derive(Resource, Default)]
struct Textures(Vec<(u16, [Handle<Image>; 3])>);

impl Textures {
    /// Checks, bricks, and the normals of bricks.
    fn get(&mut self, anisotropy: u16, images: &mut Assets<Image>) -> [Handle<Image>; 3] {
        if let Some((_, textures)) = self.0.iter().find(|(known, _)| *known == anisotropy) {
            return textures.clone();
        }
        let bricks = content::bricks(512, 512, 5);
        let pictures: [(RgbaImage, bool); 3] = [
            (checks(), true),
            (bricks.color.convert(), true),
            (bricks.normal.convert(), false),
        ];
        let textures = pictures.map(|(picture, srgb)| {
            let mut image = content::mipped_texture(&picture, srgb);
            if let ImageSampler::Descriptor(sampler) = &mut image.sampler {
                *sampler = ImageSamplerDescriptor {
                    anisotropy_clamp: anisotropy,
                    ..sampler.clone()
                };
            }
            images.add(image)
        });
        self.0.push((anisotropy, textures.clone()));
        textures
    }
}

fn checks() -> RgbaImage {
    RgbaImage::from_fn(256, 256, |x, y| {
        if (x / 32 + y / 32) % 2 == 0 {
            Rgba([240, 236, 225, 255])
        } else {
            Rgba([24, 32, 52, 255])
        }
    })
}

/// Spawns both places for both sides, and a sun.
fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>) {
    for side in Side::BOTH {
        for (place, mesh) in [(Place::Tunnel, tunnel()), (Place::Floor, floor())] {
            commands.spawn((side, side.layers(), place, Mesh3d(meshes.add(mesh))));
        }
        commands.spawn((
            side.layers(),
            DirectionalLight {
                illuminance: 9000.0,
                ..default()
            },
            Transform::default().looking_to(Vec3::new(0.5, -0.6, -0.6), Vec3::Y),
        ));
    }
}

/// The inside of a cylinder of radius 1 along z, four textures around.
fn tunnel() -> Mesh {
    const SEGMENTS: u32 = 96;
    const HALF_LENGTH: f32 = 400.0;
    let (mut positions, mut normals, mut uvs) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..=SEGMENTS {
        let part = i as f32 / SEGMENTS as f32;
        let (sin, cos) = (part * TAU).sin_cos();
        for z in [-HALF_LENGTH, HALF_LENGTH] {
            positions.push([cos, sin, z]);
            normals.push([-cos, -sin, 0.0]);
            uvs.push([4.0 * part, 0.5 * z]);
        }
    }
    let faces = (0..SEGMENTS).flat_map(|i| {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| 2 * i + k);
        [a, c, b, b, c, d]
    });
    mesh(positions, normals, uvs, faces.collect())
}

/// A plane one unit below the eye.
fn floor() -> Mesh {
    const HALF: f32 = 300.0;
    let corners = [[-HALF, -HALF], [-HALF, HALF], [HALF, HALF], [HALF, -HALF]];
    mesh(
        corners.map(|[x, z]| [x, -1.0, z]).to_vec(),
        vec![[0.0, 1.0, 0.0]; 4],
        corners.map(|[x, z]| [0.5 * x, 0.5 * z]).to_vec(),
        vec![0, 1, 2, 0, 2, 3],
    )
}

fn mesh(
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    indices: Vec<u32>,
) -> Mesh {
    let mut mesh = Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::RENDER_WORLD,
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
    .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
    .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs)
    .with_inserted_indices(Indices::U32(indices));
    if let Err(error) = mesh.generate_tangents() {
        warn!("no tangents: {error}");
    }
    mesh
}

/// Shows the chosen place only.
fn show_place(settings: Res<SceneSettings>, mut places: Query<(&Place, &mut Visibility)>) {
    for (place, mut visibility) in &mut places {
        visibility.set_if_neq(if *place == PLACE.of(&settings) {
            Visibility::Inherited
        } else {
            Visibility::Hidden
        });
    }
}

/// Gives each surface the material that the settings ask for.
fn configure(
    mut commands: Commands,
    settings: Res<SceneSettings>,
    mut textures: ResMut<Textures>,
    mut images: ResMut<Assets<Image>>,
    mut materials: ResMut<Assets<EwaStandardMaterial>>,
    mut views: ResMut<Assets<ViewMaterial>>,
    places: Query<(Entity, &Side, &Place)>,
) {
    for (entity, side, place) in &places {
        let ewa = ewa_settings(&settings, *side);
        // A texture has one sampler, which the plugin raises: sides with other samplers have other textures.
        let anisotropy = ewa.sampler_anisotropy.max(ewa.texture_unit_anisotropy());
        let [checks, bricks, normals] = textures.get(anisotropy, &mut images);
        let color = match place {
            Place::Tunnel => checks,
            Place::Floor => bricks,
        };
        let mut entity = commands.entity(entity);
        let view = settings.choice("view");
        if view != "picture" {
            let material = views.add(ViewMaterial::new(view, &ewa, color));
            entity
                .remove::<MeshMaterial3d<EwaStandardMaterial>>()
                .insert(MeshMaterial3d(material));
            continue;
        }
        let tunnel = *place == Place::Tunnel;
        let base = StandardMaterial {
            base_color_texture: Some(color),
            normal_map_texture: (!tunnel).then_some(normals),
            unlit: tunnel,
            perceptual_roughness: 0.8,
            double_sided: true,
            cull_mode: None,
            ..default()
        };
        let material = materials.add(EwaStandardMaterial {
            base,
            extension: ewa.into(),
        });
        entity
            .remove::<MeshMaterial3d<ViewMaterial>>()
            .insert(MeshMaterial3d(material));
    }
}

/// Moves the textures. At time 0 they are where they belong.
fn drift(
    settings: Res<SceneSettings>,
    time: Res<Time>,
    places: Query<&MeshMaterial3d<EwaStandardMaterial>>,
    mut materials: ResMut<Assets<EwaStandardMaterial>>,
) {
    let moved = if settings.toggle("motion") {
        (time.elapsed_secs() * DRIFT).fract()
    } else {
        0.0
    };
    let transform = Affine2::from_translation(Vec2::new(0.0, moved));
    for material in &places {
        let is_there = materials
            .get(&material.0)
            .is_some_and(|material| material.base.uv_transform == transform);
        if !is_there && let Some(mut material) = materials.get_mut(&material.0) {
            material.base.uv_transform = transform;
        }
    }
}
