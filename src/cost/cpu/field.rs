//! A field of meshes, all of them in view.

use bevy::prelude::*;

use crate::{
    cost::{
        app::{add_plugin, spawn_camera},
        configurations::Kind,
        error::CostError,
        scene::Scene,
        skin::{SMALL_TEXTURE, Skin},
    },
    headless::{HeadlessApp, HeadlessSettings},
};

const MESHES: [usize; 3] = [1_000, 10_000, 100_000];
const MATERIALS: [usize; 2] = [1, 100];
/// One of this many meshes moves or is replaced, where some are.
const MOVING: usize = 100;
/// The number of meshes of which some are replaced.
const REPLACED_OF: usize = 10_000;
/// Edge of the field in metres.
const FIELD: f32 = 40.0;

/// How many there are of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field {
    pub meshes: usize,
    pub materials: usize,
    /// Meshes that move in every frame.
    pub moving: usize,
    /// Meshes that are despawned in every frame, and as many spawned in their place.
    pub replaced: usize,
}

impl Field {
    /// All that are measured.
    pub fn all() -> impl Iterator<Item = Self> {
        let fields = MESHES.into_iter().flat_map(|meshes| {
            MATERIALS.into_iter().flat_map(move |materials| {
                [0, meshes / MOVING].map(|moving| Self {
                    meshes,
                    materials,
                    moving,
                    replaced: 0,
                })
            })
        });
        fields.chain([Self {
            meshes: REPLACED_OF,
            materials: 1,
            moving: 0,
            replaced: REPLACED_OF / MOVING,
        }])
    }

    /// The name of the part of the work that is a plugin in this field.
    pub fn part(self, plugin: &str) -> String {
        let Self {
            meshes,
            materials,
            moving,
            replaced,
        } = self;
        format!("{plugin} {meshes} {materials} {moving} {replaced}")
    }

    /// The plugin and the field of a part.
    ///
    /// # Errors
    /// [`CostError::Failed`] where it is none.
    pub fn of_part(part: &str) -> Result<(String, Self), CostError> {
        let words: Vec<_> = part.split(' ').collect();
        let number = |i: usize| words.get(i).and_then(|word| word.parse().ok());
        match (words.first(), number(1), number(2), number(3), number(4)) {
            (Some(plugin), Some(meshes), Some(materials), Some(moving), Some(replaced)) => {
                let field = Self {
                    meshes,
                    materials,
                    moving,
                    replaced,
                };
                Ok(((*plugin).to_owned(), field))
            }
            _ => Err(CostError::Failed(format!("no such part: `{part}`"))),
        }
    }
}

#[derive(Component)]
struct Moving;

#[derive(Component, Clone)]
struct Replaced;

/// The app, before its first frame.
///
/// # Errors
/// [`CostError::App`] where there is no adapter.
pub fn app(field: Field, kind: &Kind) -> Result<HeadlessApp, CostError> {
    let mut app = HeadlessApp::new(HeadlessSettings::with_size(64, 64), |app| {
        add_plugin(app, kind);
        app.add_systems(Update, (shake, replace));
    })?;
    let world = app.world_mut();
    spawn_camera(world, kind, Scene::BaseColor);
    let mut cameras = world.query_filtered::<&mut Transform, With<Camera3d>>();
    for mut camera in cameras.iter_mut(world) {
        *camera = Transform::from_xyz(0.0, FIELD, FIELD).looking_at(Vec3::ZERO, Vec3::Y);
    }
    world.spawn((PointLight::default(), Transform::from_xyz(0.0, 4.0, 0.0)));
    let side = (field.meshes as f32).sqrt().ceil() as usize;
    let step = FIELD / side as f32;
    let mesh = Mesh::from(Cuboid::from_length(0.5 * step));
    let mesh = Mesh3d(world.resource_mut::<Assets<Mesh>>().add(mesh));
    let skins: Vec<_> = (0..field.materials)
        .map(|_| Skin::new(world, kind, Scene::BaseColor, SMALL_TEXTURE))
        .collect();
    for i in 0..field.meshes {
        let at = Vec3::new((i % side) as f32, 0.0, (i / side) as f32) * step;
        let place = Transform::from_translation(at - Vec3::new(0.5, 0.0, 0.5) * FIELD);
        let mut entity = world.spawn((mesh.clone(), place));
        if field.moving > 0 && i % MOVING == 0 {
            entity.insert(Moving);
        }
        if field.replaced > 0 && i % MOVING == 0 {
            entity.insert(Replaced);
        }
        skins[i % skins.len()].put_on(entity);
    }
    if let Kind::Gi(settings, volume) = kind {
        let mut volume = volume.clone();
        volume.size = FIELD;
        world.insert_resource(settings.clone());
        world.spawn(volume);
    }
    Ok(app)
}

fn shake(time: Res<Time>, mut moving: Query<&mut Transform, With<Moving>>) {
    for mut place in &mut moving {
        place.translation.y = time.elapsed_secs().sin();
    }
}

fn replace(mut commands: Commands, replaced: Query<Entity, With<Replaced>>) {
    for entity in &replaced {
        commands.entity(entity).clone_and_spawn();
        commands.entity(entity).despawn();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_read_back() {
        for field in Field::all() {
            let read = Field::of_part(&field.part("ewa")).expect("a part");
            assert_eq!(read, ("ewa".to_owned(), field));
        }
        assert!(Field::of_part("ewa").is_err());
    }
}
