//! What the volumes need of the main world, whether a camera sees it or not.
//!
//! | module | what it contains |
//! | --- | --- |
//! | [`placement`], [`place_volume`] | where the volumes are, and their settings; their extraction |
//! | [`device_limits`] | the resolution that a device can hold, and whether it runs the passes |
//! | [`game_sky`] | the sky that a camera shows |
//! | [`probe`] | the light probe through which Bevy reads the volumes, and its texture |
//! | [`meshes`], [`deformed_meshes`] | extraction of rigid meshes, which are kept from frame to frame, and of those with a skin or morph targets |
//! | [`outer_levels`] | the levels around the volumes, in which rays see the world outside |
//! | [`changed_rows`] | the meshes of which a component has changed, or that have come or gone |
//! | [`lights`] | extraction of lights and their textures |
//! | [`voxel_material`] | what voxels use of a material |
//! | [`material_table`] | the table of the materials in use, and what keeps it in sync |

pub(crate) mod changed_rows;
pub(crate) mod deformed_meshes;
pub(crate) mod device_limits;
pub(crate) mod game_sky;
pub(crate) mod lights;
pub(crate) mod material_table;
pub(crate) mod meshes;
pub(crate) mod outer_levels;
pub(crate) mod place_volume;
pub(crate) mod placement;
pub(crate) mod probe;
pub(crate) mod voxel_material;
