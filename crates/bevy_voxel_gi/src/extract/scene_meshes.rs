//! The meshes of the scene, kept from frame to frame.

use bevy::{ecs::entity::EntityIndexMap, prelude::*};

use super::meshes::ExtractedMesh;
use crate::prepare::mesh_batches::PlacedMesh;

/// A mesh of the scene.
#[derive(Default)]
pub(crate) struct SceneMesh {
    /// The mesh in this frame; `None` if it has gone.
    pub now: Option<ExtractedMesh>,
    /// Its place in the groups, if it is voxelised.
    pub placed: Option<PlacedMesh>,
}

/// The meshes of the scene. Those that have changed lately come first, in the order in which they change, so that what
/// moves is read from memory in a row.
#[derive(Default)]
pub(crate) struct SceneMeshes {
    all: EntityIndexMap<SceneMesh>,
    /// Number of those that have changed lately: at most a quarter of all, or twice as many as change in a frame.
    recent: usize,
    /// The indices of those that changed or went in this frame.
    changed: Vec<usize>,
    /// The meshes that rested until this frame, as they were.
    left: Vec<ExtractedMesh>,
    /// Whether the resting meshes are other ones than when their bounds were found.
    rest_is_new: bool,
}

impl SceneMeshes {
    pub(super) fn begin_frame(&mut self) {
        let most = (2 * self.changed.len()).max(self.all.len() / 4);
        if self.recent > most {
            self.forget_recent();
        }
        self.changed.clear();
        self.left.clear();
    }

    fn forget_recent(&mut self) {
        self.recent = 0;
        self.rest_is_new = true;
    }

    /// Stores what a mesh is now.
    pub(super) fn set(&mut self, entity: Entity, mesh: Option<ExtractedMesh>) {
        // Where what moves is the same from frame to frame, it is the next one.
        let next = self.changed.last().map_or(0, |last| last + 1);
        let is_next = self.all.get_index(next).is_some_and(|(e, _)| *e == entity);
        let known = if is_next {
            Some(next)
        } else {
            self.all.get_index_of(&entity)
        };
        let mut index = match (known, &mesh) {
            (Some(index), _) => index,
            (None, Some(_)) => self.all.insert_full(entity, default()).0,
            (None, None) => return,
        };
        if self.all[index].now == mesh {
            return;
        }
        if index >= self.recent {
            self.left.extend(self.all[index].now);
            self.all.swap_indices(index, self.recent);
            index = self.recent;
            self.recent += 1;
        }
        self.all[index].now = mesh;
        self.changed.push(index);
    }

    pub(super) fn get(&self, entity: Entity) -> Option<ExtractedMesh> {
        self.all.get(&entity)?.now
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &SceneMesh> {
        self.all.values()
    }

    /// The meshes that have changed lately, and the resting ones.
    pub(super) fn recent_and_resting(&self) -> [impl Iterator<Item = &ExtractedMesh>; 2] {
        let meshes = self.all.as_slice();
        let (recent, resting) = meshes.split_at(self.recent);
        [recent, resting].map(|meshes| meshes.values().filter_map(|mesh| mesh.now.as_ref()))
    }

    /// The meshes that rested until this frame, as they were; `None` if the others are not those of the last call.
    pub(super) fn take_left(&mut self) -> Option<Vec<ExtractedMesh>> {
        let left = std::mem::take(&mut self.left);
        (!std::mem::take(&mut self.rest_is_new)).then_some(left)
    }

    /// Calls a function with those that changed in this frame.
    pub(crate) fn update_changed(&mut self, mut update: impl FnMut(&mut SceneMesh)) {
        let mut gone = Vec::new();
        for index in &self.changed {
            if let Some((entity, mesh)) = self.all.get_index_mut(*index) {
                update(mesh);
                if mesh.now.is_none() {
                    gone.push(*entity);
                }
            }
        }
        for entity in gone {
            if let Some(index) = self.all.get_index_of(&entity) {
                // One that rests takes its place, which must not be among the recent ones.
                self.recent -= 1;
                self.all.swap_indices(index, self.recent);
                self.all.swap_remove_index(self.recent);
            }
        }
    }

    /// Calls a function with all of them, and with whether they changed in this frame.
    pub(crate) fn update_all(&mut self, mut update: impl FnMut(&mut SceneMesh, bool)) {
        let mut has_changed = vec![false; self.all.len()];
        for index in &self.changed {
            has_changed[*index] = true;
        }
        let mut has_changed = has_changed.into_iter();
        let count = self.all.len();
        self.all.retain(|_, mesh| {
            update(mesh, has_changed.next() == Some(true));
            mesh.now.is_some()
        });
        if self.all.len() < count {
            self.forget_recent();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    fn mesh(material: u32) -> ExtractedMesh {
        ExtractedMesh {
            material,
            ..ExtractedMesh::with_bounds(None)
        }
    }

    /// What is kept is what was set last, exactly what has changed is updated, and what rests has not changed since it
    /// was asked for.
    #[test]
    fn meshes_that_come_move_and_go_are_those_of_a_plain_map() {
        let mut meshes = SceneMeshes::default();
        let mut expected = BTreeMap::new();
        let mut resting: Option<Vec<u32>> = None;
        let mut state = 7_u32;
        let mut random = |below: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % below
        };
        for frame in 0..400 {
            meshes.begin_frame();
            let before = expected.clone();
            // A crowd that moves, and what comes and goes.
            let crowd = (20..28).map(|id| (id, Some(1000 + frame)));
            let others = (0..random(6)).map(|_| (random(120), Some(random(3)).filter(|i| *i > 0)));
            for (id, material) in crowd.chain(others.collect::<Vec<_>>()) {
                let entity = Entity::from_raw_u32(id).expect("an index");
                meshes.set(entity, material.map(mesh));
                match material {
                    Some(material) => expected.insert(id, material),
                    None => expected.remove(&id),
                };
            }
            let [_, rest] = meshes.recent_and_resting();
            let mut rest: Vec<_> = rest.map(|mesh| mesh.material).collect();
            rest.sort_unstable();
            if let (Some(left), Some(resting)) = (meshes.take_left(), &mut resting) {
                for mesh in left {
                    let index = resting.iter().position(|m| *m == mesh.material);
                    resting.remove(index.expect("it rested"));
                }
                assert_eq!(rest, *resting, "frame {frame}");
            }
            resting = Some(rest);
            let mut updated = 0;
            if frame % 7 == 0 {
                meshes.update_all(|_, has_changed| updated += usize::from(has_changed));
            } else {
                meshes.update_changed(|_| updated += 1);
            }
            let is_other = |id: &u32| before.get(id) != expected.get(id);
            let ids = (0..120).filter(is_other).count();
            assert!(updated >= ids, "frame {frame}: {updated} of {ids}");
            assert_eq!(meshes.iter().count(), expected.len());
            for (id, material) in &expected {
                let found = meshes.get(Entity::from_raw_u32(*id).expect("an index"));
                assert_eq!(found.map(|mesh| mesh.material), Some(*material), "{id}");
            }
        }
    }
}
