//! What a user sets or reads can be inspected: it is registered by its plugin, where Bevy does not register it by itself.

use std::{
    any::TypeId,
    fmt::Debug,
    ops::RangeInclusive,
    path::{Path, PathBuf},
};

use bevy::{
    ecs::{
        entity::EntityMapper,
        reflect::{ReflectComponent, ReflectMessage, ReflectResource},
    },
    prelude::*,
    reflect::{TypeRegistry, Typed, structs::Struct},
    scene::ScenePlugin,
};
use bevy_ewa::{EwaPlugin, EwaSettings};
use bevy_frugal_lab::ROOT;
use bevy_voxel_gi::{
    DebugField, Follow, FollowTemplate, MeshVoxelMaterial, NotVoxelized, VoxelGiBudgetPlugin,
    VoxelGiDebug, VoxelGiLight, VoxelGiPlugin, VoxelGiSettings, VoxelGiVolume,
};
use bevy_wavelet_tex::{WaveletFilter, WaveletGltf, WaveletTexPlugin};
use bevy_ycocg_fb::{FrameBufferQuality, FrameBufferReport, YCoCgFrameBufferPlugin};

use crate::{
    pages::PLUGINS,
    support::{gpu, headless},
};

/// Resources of the render world, which nobody sets or reads.
const INTERNAL: [&str; 1] = ["WaveletSamplers"];

fn rust_files(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        match path.is_dir() {
            true => rust_files(&path, files),
            false if path.extension().is_some_and(|end| end == "rs") => files.push(path),
            false => {}
        }
    }
}

/// The public types of a source that derive `trait_name`.
fn deriving(source: &str, trait_name: &str) -> Vec<String> {
    let items = source.split("\n\n").flat_map(|text| text.split("\n}\n"));
    let types = items.filter_map(|item| {
        let (attributes, item) =
            { item.split_once("\npub struct ") }.or_else(|| item.split_once("\npub enum "))?;
        let code = attributes.lines().filter(|line| !line.starts_with("//"));
        let code: String = code.flat_map(|line| [line, "\n"]).collect();
        let derives = code.split("derive(").skip(1);
        let derived: Vec<_> = derives
            .filter_map(|list| list.split(')').next())
            .flat_map(|list| list.split(',').map(str::trim))
            .collect();
        let name = item.split(|c: char| !c.is_alphanumeric()).next()?;
        derived.contains(&trait_name).then(|| name.to_string())
    });
    types
        .filter(|name| !INTERNAL.contains(&name.as_str()))
        .collect()
}

fn has(registry: &TypeRegistry, name: &str, kind: &str) -> bool {
    let Some(registration) = registry.get_with_short_type_path(name) else {
        return false;
    };
    let is_default = registration.contains::<ReflectDefault>();
    match kind {
        "Component" => is_default && registration.contains::<ReflectComponent>(),
        "Resource" => is_default && registration.contains::<ReflectResource>(),
        "Message" => registration.contains::<ReflectMessage>(),
        _ => true,
    }
}

#[test]
fn what_a_user_sets_or_reads_is_registered() {
    let _gpu = gpu();
    let add = |app: &mut App| {
        // Bevy's own has all types of the process, with the feature `reflect_auto_register`.
        app.insert_resource(AppTypeRegistry::default());
        app.add_plugins((
            EwaPlugin::default(),
            VoxelGiPlugin,
            VoxelGiBudgetPlugin,
            WaveletTexPlugin,
            YCoCgFrameBufferPlugin,
        ));
        let registry = app.world().resource::<AppTypeRegistry>().read();
        let mut found = 0;
        let mut missing = vec![];
        for plugin in PLUGINS {
            let mut files = vec![];
            let folder = Path::new(ROOT).join("crates").join(plugin).join("src");
            rust_files(&folder, &mut files);
            for file in files {
                let source = std::fs::read_to_string(&file).expect("a source");
                for kind in ["Component", "Resource", "Asset", "Message"] {
                    for name in deriving(&source, kind) {
                        found += 1;
                        if !has(&registry, &name, kind) {
                            missing.push(format!("{plugin}: {name} as {kind}"));
                        }
                    }
                }
            }
        }
        assert!(found > 15, "{found}");
        assert!(missing.is_empty(), "{missing:#?}");
    };
    headless(1, 1, add);
}

/// As when a scene is spawned: entities in fields are those of the new world.
#[test]
fn a_volume_follows_the_entity_that_was_spawned_with_it() {
    struct Next;
    impl EntityMapper for Next {
        fn get_mapped(&mut self, source: Entity) -> Entity {
            Entity::from_raw_u32(source.index_u32() + 1).expect("an entity")
        }
        fn set_mapped(&mut self, _: Entity, _: Entity) {}
    }
    let entity = |index| Entity::from_raw_u32(index).expect("an entity");
    let mut volume = VoxelGiVolume {
        follow: Follow::Entity(entity(3)),
        ..default()
    };
    let mut registry = TypeRegistry::new();
    registry.register::<VoxelGiVolume>();
    let reflected = registry.get_type_data::<ReflectComponent>(TypeId::of::<VoxelGiVolume>());
    reflected
        .expect("registered")
        .map_entities(&mut volume, &mut Next);
    assert_eq!(volume.follow, Follow::Entity(entity(4)));
}

/// Checks the fields whose range is an attribute of this type, and returns their number.
fn check_ranges<T, N>(value: &T, clamped: impl Fn(&T) -> T, beyond: [N; 2]) -> usize
where
    T: Struct + Typed + Clone,
    N: Reflect + TypePath + Clone + PartialEq + Debug,
{
    let info = T::type_info().as_struct().expect("a struct");
    let mut ranges = 0;
    for field in info.iter() {
        let Some(range) = field.get_attribute::<RangeInclusive<N>>() else {
            continue;
        };
        ranges += 1;
        for (beyond, end) in beyond.iter().zip([range.start(), range.end()]) {
            let mut changed = value.clone();
            changed.field_mut(field.name()).expect("it").apply(beyond);
            let clamped = clamped(&changed);
            let found = clamped.field(field.name()).expect("it");
            let found = found.try_downcast_ref::<N>();
            assert_eq!(found, Some(end), "{}", field.name());
        }
    }
    ranges
}

#[test]
fn ranges_that_an_inspector_reads_are_those_that_hold() {
    let whole = [0, u32::MAX];
    let settings = VoxelGiSettings::default();
    assert_eq!(check_ranges(&settings, VoxelGiSettings::clamped, whole), 3);
    let volume = VoxelGiVolume::default();
    assert_eq!(check_ranges(&volume, VoxelGiVolume::clamped, whole), 1);
    let ewa = EwaSettings::default();
    let clamped = |settings: &EwaSettings| settings.clamped();
    assert_eq!(check_ranges(&ewa, clamped, whole), 1);
    assert_eq!(check_ranges(&ewa, clamped, [0, u16::MAX]), 1);
    assert_eq!(check_ranges(&ewa, clamped, [f32::MIN, f32::MAX]), 4);
}

/// What a user spawns can be written in `bsn!`, and an entity in a field is that of the scene.
#[test]
fn components_are_spawned_from_scenes() -> Result {
    let mut app = App::new();
    app.add_plugins((
        TaskPoolPlugin::default(),
        AssetPlugin::default(),
        ScenePlugin,
    ));
    let world = app.world_mut();
    let root = world
        .spawn_scene(bsn! {
            #Root
            VoxelGiVolume { size: 4.0, follow: FollowTemplate::Entity(#Player) }
            VoxelGiLight { factor: 0.5 }
            VoxelGiDebug { field: DebugField::Normal }
            MeshVoxelMaterial { coverage: {Some(0.25)} }
            NotVoxelized
            FrameBufferQuality::Compact
            FrameBufferReport
            WaveletGltf { filter: WaveletFilter::Nearest }
            Children [#Player]
        })?
        .id();
    let root = world.entity(root);
    let player = root.get::<Children>().expect("a child")[0];
    let volume = VoxelGiVolume {
        size: 4.0,
        follow: Follow::Entity(player),
        ..default()
    };
    assert_eq!(root.get(), Some(&volume));
    assert_eq!(root.get(), Some(&VoxelGiLight { factor: 0.5 }));
    let field = root.get::<VoxelGiDebug>().map(|it| it.field);
    assert_eq!(field, Some(DebugField::Normal));
    let coverage = root.get::<MeshVoxelMaterial>().and_then(|it| it.coverage);
    assert_eq!(coverage, Some(0.25));
    assert!(root.contains::<NotVoxelized>());
    assert_eq!(root.get(), Some(&FrameBufferQuality::Compact));
    assert!(root.contains::<FrameBufferReport>());
    let filter = root.get::<WaveletGltf>().map(|it| it.filter);
    assert_eq!(filter, Some(WaveletFilter::Nearest));
    Ok(())
}
