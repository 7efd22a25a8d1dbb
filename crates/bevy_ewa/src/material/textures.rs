//! Finds what textures need whose images or materials have changed.

use std::collections::HashSet;

use bevy::prelude::*;

use super::{
    filtered::{FilteredMaterials, FilteredTexture, FindSystems},
    images::ImageShape,
    wanted::{WantedTexture, stricter},
};
use crate::{
    mips::NoMips,
    report::{EwaReport, MipReport, TextureReport},
};

/// Follows what the textures of filtered materials need.
pub(super) struct TexturesPlugin;

impl Plugin for TexturesPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<EwaReport>()
            .init_resource::<EwaReport>()
            .add_systems(PostUpdate, find_textures.in_set(FindSystems::Textures));
    }
}

impl FilteredMaterials {
    /// What the materials that show an image want of its texture, and what it got.
    fn texture(
        &self,
        id: AssetId<Image>,
        image: &ImageShape,
    ) -> Option<(WantedTexture, TextureReport)> {
        let users = self.users.get(&id)?;
        let users = users.iter().filter_map(|user| self.materials.get(user));
        let uses = users.flat_map(|user| user.textures.iter().filter(|used| used.image == id));
        let used = uses.copied().reduce(|a, b| FilteredTexture {
            image: id,
            content: stricter(a.content, b.content),
            anisotropy: a.anisotropy.max(b.anisotropy),
            is_elliptical: a.is_elliptical || b.is_elliptical,
        })?;
        let sampler = image.with_anisotropy(used.anisotropy);
        let report = TextureReport {
            mips: image.mips,
            anisotropy: sampler.as_ref().unwrap_or(&image.sampler).anisotropy_clamp,
            is_elliptical: used.is_elliptical,
        };
        let texture = WantedTexture {
            levels: match image.mips {
                MipReport::Generated(levels) => levels,
                MipReport::Own(_) | MipReport::Without(_) => 1,
            },
            format: image.mip_format,
            content: used.content,
            sampler,
            after_draws: image.after_draws,
        };
        Some((texture, report))
    }
}

/// Finds what the textures need whose images or users have changed.
fn find_textures(mut filtered: ResMut<FilteredMaterials>, mut report: ResMut<EwaReport>) {
    let filtered = &mut *filtered;
    let mut used = std::mem::take(&mut filtered.changes.used);
    used.extend(filtered.changes.images.keys());
    for id in &used {
        let image = filtered.images.get(*id);
        let found = image.and_then(|image| filtered.texture(*id, image));
        let (texture, reported) = found.unzip();
        let reported = reported.or_else(|| {
            // Materials wait for it.
            let is_awaited = filtered
                .users
                .get(id)
                .is_some_and(|users| !users.is_empty());
            is_awaited.then_some(TextureReport {
                mips: MipReport::Without(NoMips::NotLoaded),
                anisotropy: 1,
                is_elliptical: false,
            })
        });
        if report.textures.get(id) != reported.as_ref() {
            match reported {
                Some(reported) => report.textures.insert(*id, reported),
                None => report.textures.remove(id),
            };
        }
        if filtered.users.get(id).is_some_and(HashSet::is_empty) {
            filtered.users.remove(id);
        }
        let former = match texture.clone() {
            Some(texture) => filtered.textures.insert(*id, texture),
            None => filtered.textures.remove(id),
        };
        // A material keeps the views and samplers with which it was prepared. Bevy replaces the texture of an image
        // with another shape, and does not prepare the materials again that show it.
        let is_new = filtered.changes.images.get(id).copied();
        if is_new != Some(true) && (former != texture || is_new.is_some()) {
            let users = filtered.users.get(id).into_iter().flatten();
            filtered.changes.stale.extend(users);
        }
        if former != texture {
            filtered.changes.textures.push((*id, texture));
        }
    }
}
