//! The integration tests of the lab and of the plugins, in one binary.

mod all_together;
mod cost;
mod deferred_accumulation;
mod ewa;
mod ewa_scene;
mod ewa_study;
mod examples;
mod extremes;
mod figures;
mod headless;
mod hooks;
mod import_cycles;
mod pages;
mod runner;
mod scene_settings;
mod support;
mod tradeoff;
mod unused;
mod voxel_gi;
mod voxel_gi_scene;
mod voxel_gi_study;
mod wavelet_tex;
mod wavelet_tex_scene;
mod ycocg_fb;
mod ycocg_scene;
mod ycocg_study;
