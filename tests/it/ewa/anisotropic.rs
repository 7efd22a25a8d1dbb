//! The texture unit's own anisotropic filter: Bevy's pipelines with other samplers.

use bevy::{
    image::{ImageSampler, ImageSamplerDescriptor},
    prelude::*,
    render::{
        RenderApp,
        render_resource::{PipelineCache, PipelineDescriptor, TextureFormat},
    },
    shader::ShaderDefVal,
};
use bevy_ewa::{EwaMaps, EwaMethod, EwaPlugin, EwaProbes, EwaSettings};
use bevy_frugal_lab::{headless::HeadlessSettings, metrics::error::mse};

use super::scene::{Floor, all, checkered, checks, texture};
use crate::support::{gpu, keep, psnr};

fn anisotropic() -> EwaSettings {
    EwaSettings::with_method(EwaMethod::Anisotropic)
}

fn size() -> HeadlessSettings {
    HeadlessSettings::with_size(96, 64)
}

/// A floor of checks whose sampler is given by hand, in an app of its own.
fn by_hand(plugin: Option<EwaPlugin>, anisotropy_clamp: u16) -> Floor {
    let mut floor = Floor::with_settings(size(), plugin, |images| {
        let material = checkered(true)(images);
        let id = material
            .base_color_texture
            .as_ref()
            .expect("a texture")
            .id();
        let mut image = images.get_mut(id).expect("the texture");
        if let ImageSampler::Descriptor(sampler) = &mut image.sampler {
            sampler.anisotropy_clamp = anisotropy_clamp;
        }
        material
    });
    floor.clear();
    floor
}

/// The number of pipelines, and of those with a shader def of the filter.
fn pipelines(floor: &mut Floor) -> (usize, usize) {
    let is_ours = |def: &ShaderDefVal| match def {
        ShaderDefVal::Bool(name, _) | ShaderDefVal::Int(name, _) | ShaderDefVal::UInt(name, _) => {
            name.contains("EWA")
        }
    };
    let render_app = floor.app.app_mut().sub_app(RenderApp);
    let cache = render_app.world().resource::<PipelineCache>();
    let descriptors = cache.pipelines().map(|pipeline| &pipeline.descriptor);
    let filtered = descriptors.filter(|descriptor| match descriptor {
        PipelineDescriptor::RenderPipelineDescriptor(descriptor) => {
            let fragment = descriptor.fragment.as_ref();
            fragment.is_some_and(|fragment| fragment.shader_defs.iter().any(is_ours))
        }
        _ => false,
    });
    (cache.pipelines().count(), filtered.count())
}

#[test]
fn samplers_get_anisotropy_and_pipelines_stay_bevys_own() {
    let _gpu = gpu();
    let mut stock = by_hand(None, 1);
    let trilinear = stock.picture();
    let expected = by_hand(None, 16).picture();
    let mut floor = by_hand(all(anisotropic()), 1);
    let ours = floor.picture();
    keep("anisotropic_16", &ours);
    keep("anisotropic_1", &trilinear);
    assert!(ours == expected, "{} dB", psnr(&ours, &expected));
    assert_eq!(pipelines(&mut floor), (pipelines(&mut stock).0, 0));
    // The driver here heeds anisotropy, and it is worth something.
    let exact = floor.all(Some(EwaSettings::with_method(EwaMethod::Reference)));
    assert!(pipelines(&mut floor).1 > 0);
    let error = |picture| mse(picture, &exact).expect("equal sizes");
    println!(
        "MSE against exact EWA: 16x {:.1}, trilinear {:.1}",
        error(&ours),
        error(&trilinear)
    );
    assert!(error(&ours) < error(&trilinear) && psnr(&ours, &trilinear) < 30.0);
    // And back.
    assert!(floor.all(None) == trilinear);
    let four = EwaSettings {
        sampler_anisotropy: 4,
        ..anisotropic()
    };
    assert!(floor.all(Some(four)) == by_hand(None, 4).picture());
    assert!(floor.all(Some(anisotropic())) == expected);
}

#[test]
fn a_chosen_material_gets_anisotropy_without_the_others() {
    let _gpu = gpu();
    let mut floor = by_hand(Some(EwaPlugin::OPT_IN), 1);
    assert!(floor.chosen(anisotropic()) == by_hand(None, 16).picture());
    assert_eq!(pipelines(&mut floor).1, 0);
}

/// The graphics interfaces refuse anisotropy with nearest filters.
#[test]
fn samplers_that_are_not_linear_stay_as_they_are() {
    let _gpu = gpu();
    let nearest = |plugin| {
        let mut floor = Floor::with_settings(size(), plugin, |images| {
            let texels = checks([250, 250, 240, 255], [20, 30, 60, 255]);
            let mut image = texture(true, TextureFormat::Rgba8UnormSrgb, texels);
            image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor::nearest());
            StandardMaterial {
                base_color_texture: Some(images.add(image)),
                ..default()
            }
        });
        floor.clear();
        floor.picture()
    };
    assert!(nearest(all(anisotropic())) == nearest(None));
}

#[test]
fn maps_that_are_not_chosen_are_the_texture_units() {
    let _gpu = gpu();
    let settings = |maps, sampler_anisotropy| EwaSettings {
        maps,
        sampler_anisotropy,
        ..default()
    };
    let mut floor = by_hand(all(settings(EwaMaps::NONE, 1)), 1);
    assert!(floor.picture() == by_hand(None, 1).picture());
    assert_eq!(pipelines(&mut floor).1, 0);
    let raised = floor.all(Some(settings(EwaMaps::NONE, 16)));
    assert!(raised == by_hand(None, 16).picture());
    // A texture that an exact method filters keeps its sampler.
    let exact = floor.all(Some(settings(EwaMaps::default(), 1)));
    assert!(floor.all(Some(settings(EwaMaps::default(), 16))) == exact);
}

/// Probes by the texture unit need no more than the setting. Software drivers filter them otherwise, so that only
/// the sampler is checked.
#[test]
fn probes_raise_the_samplers_themselves() {
    let _gpu = gpu();
    let probes = EwaSettings {
        sampler_anisotropy: 16,
        ..EwaSettings::with_method(EwaMethod::Approximate {
            probes: EwaProbes::Five,
        })
    };
    let raised = by_hand(all(probes), 1).picture();
    assert!(raised == by_hand(all(probes), 16).picture());
}
