//! A volume, and what it has for itself.

use bevy::{
    ecs::{
        entity::{EntityMapper, MapEntities},
        template::{SpecializeFromTemplate, TemplateContext},
    },
    prelude::*,
};

use super::{Sky, VoxelGiSettings, clamped_or};

/// A part of the world in which light bounces.
///
/// By default it is around the camera, and reaches 64 m in each direction: four cubes of voxels, each twice as large as
/// the one before. [`fixed`](Self::fixed) is a single cube around the entity's position.
///
/// Every material in the cubes that uses Bevy's lighting receives indirect light without a change, whether it is in a
/// camera's view or not. Around the outermost cube, the light fades over two of its voxels into what Bevy has there
/// (environment maps and ambient light). Every entity with a `Mesh3d` gives light and hides light, in the cubes and around
/// them: rays that leave the cubes go on through up to three coarser ones, out to the bounds of the scene, but not
/// farther than 64 times the size of the outermost cube. In these, meshes that are smaller than a quarter of a voxel, and
/// those with a skin or morph targets, do not count.
///
/// The entity's rotation and scale are ignored. A volume that is hidden (`Visibility`) is as one that is not there.
///
/// Cameras receive the light if they share a layer with the volume (`RenderLayers`; by default all are in layer 0).
/// Meshes and lights count if they share a layer with the volume or with such a camera. Of the levels of detail of a mesh (`VisibilityRange`), the one that is seen
/// at a distance of 0 counts, wherever cameras are.
///
/// There may be several volumes, side by side or nested: a pixel is lit by the smallest one that
/// contains it, and a ray that leaves a volume continues in a larger one that contains or adjoins it, and then
/// in the cubes around all of them. A ray that leaves these returns the sky of the volume that it left. What all volumes share is in
/// [`VoxelGiSettings`]; their render layers are those of the one spawned first. At most eight cubes
/// are supported, where each cascade of each volume counts as one; volumes beyond this limit are left
/// out with a warning.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Default, Clone)]
#[require(Transform, Visibility)]
pub struct VoxelGiVolume {
    /// Edge of the cube in metres, above 0. Default 16. With [`cascades`](Self::cascades), this is the
    /// edge of the smallest cube.
    pub size: f32,
    /// The light that comes from outside of the scene. Default `None`: the game's own sky, which is that of the active 3D
    /// camera that shows the volume in a window. It has the light of the camera's environment map
    /// (`GeneratedEnvironmentMapLight`, `EnvironmentMapLight`, `AtmosphereEnvironmentMapLight`), or else of its
    /// atmosphere (`AtmosphereSettings`) or `Skybox`, and ambient light (`AmbientLight`, or else `GlobalAmbientLight`).
    pub sky: Option<Sky>,
    /// Number of concentric cubes, each twice as large as the one before, all of the same resolution:
    /// 1 to 4. Default 4. With [`Solver::Propagate`](crate::Solver::Propagate) it is 1. Each further cube takes as much memory as the first. When an app first has a second
    /// level, a cascade or another volume, a frame waits until the shaders of all materials are compiled again.
    #[reflect(@1..=4_u32)]
    pub cascades: u32,
    /// The target that the volume follows, each cascade in steps of two of its voxels. Its light blends into that of the next
    /// cascade around the target itself. Default: the camera.
    #[entities]
    pub follow: Follow,
    /// Factor of the light that reaches the image, at least 0. Default 1, which is physically correct.
    pub intensity: f32,
}

impl Default for VoxelGiVolume {
    fn default() -> Self {
        Self {
            size: 16.0,
            sky: None,
            cascades: 4,
            follow: Follow::default(),
            intensity: 1.0,
        }
    }
}

impl VoxelGiVolume {
    /// Creates a cube of this edge in metres that stays at the position of its entity, such as a room or a house.
    pub fn fixed(size: f32) -> Self {
        Self {
            size,
            cascades: 1,
            follow: Follow::Nothing,
            ..Self::default()
        }
    }

    /// Returns a copy with every field clamped to its range.
    pub fn clamped(&self) -> Self {
        Self {
            size: clamped_or(self.size, 1e-3, 1e6, 16.0),
            sky: self.sky.map(Sky::clamped),
            cascades: self.cascades.clamp(1, 4),
            follow: self.follow,
            intensity: clamped_or(self.intensity, 0.0, 1e4, 1.0),
        }
    }

    /// Returns the edge of a voxel of the smallest cascade in metres.
    pub fn voxel_size(&self, settings: &VoxelGiSettings) -> f32 {
        self.size / settings.resolution as f32
    }
}

/// A [`VoxelGiVolume`] in a scene of `bsn!`, with the same fields: the entity that it follows may have a name there,
/// as in `follow: FollowTemplate::Entity(#Player)`.
pub struct VoxelGiVolumeTemplate {
    /// [`VoxelGiVolume::size`].
    pub size: f32,
    /// [`VoxelGiVolume::sky`].
    pub sky: Option<Sky>,
    /// [`VoxelGiVolume::cascades`].
    pub cascades: u32,
    /// [`VoxelGiVolume::follow`].
    pub follow: FollowTemplate,
    /// [`VoxelGiVolume::intensity`].
    pub intensity: f32,
}

impl From<VoxelGiVolume> for VoxelGiVolumeTemplate {
    fn from(volume: VoxelGiVolume) -> Self {
        Self {
            size: volume.size,
            sky: volume.sky,
            cascades: volume.cascades,
            follow: volume.follow.into(),
            intensity: volume.intensity,
        }
    }
}

// The derived one would begin with zeros.
impl Default for VoxelGiVolumeTemplate {
    fn default() -> Self {
        VoxelGiVolume::default().into()
    }
}

impl Template for VoxelGiVolumeTemplate {
    type Output = VoxelGiVolume;

    fn build_template(&self, context: &mut TemplateContext) -> Result<VoxelGiVolume> {
        Ok(VoxelGiVolume {
            size: self.size,
            sky: self.sky,
            cascades: self.cascades,
            follow: self.follow.build_template(context)?,
            intensity: self.intensity,
        })
    }

    fn clone_template(&self) -> Self {
        Self {
            follow: self.follow.clone_template(),
            ..*self
        }
    }
}

impl FromTemplate for VoxelGiVolume {
    type Template = VoxelGiVolumeTemplate;
}

// As in what `FromTemplate` derives: without it, `Default` and `Clone` would be the template.
impl Unpin for VoxelGiVolume where for<'a> [()]: SpecializeFromTemplate {}

/// The target that a [`VoxelGiVolume`] follows.
#[derive(FromTemplate, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Follow {
    /// The active 3D camera that shows the volume in a window: of several, the one that draws last. Where there is none,
    /// the volume stays at its own position.
    #[default]
    Camera,
    /// Nothing: the volume stays at its own position.
    Nothing,
    /// An entity, such as one of several players.
    Entity(Entity),
}

impl From<Follow> for FollowTemplate {
    fn from(follow: Follow) -> Self {
        match follow {
            Follow::Camera => Self::Camera,
            Follow::Nothing => Self::Nothing,
            Follow::Entity(entity) => Self::Entity(entity.into()),
        }
    }
}

impl MapEntities for Follow {
    fn map_entities<E: EntityMapper>(&mut self, mapper: &mut E) {
        if let Self::Entity(entity) = self {
            *entity = mapper.get_mapped(*entity);
        }
    }
}
