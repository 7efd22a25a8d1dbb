//! The integration tests of the lab and of the plugins, in one binary.

mod all_together;
mod deferred_accumulation;
mod ewa;
mod examples;
mod extremes;
mod headless;
mod hooks;
mod lab;
mod pages;
mod reflection;
mod runner;
mod scenes;
mod support;
mod unused;
mod voxel_gi;
mod voxel_gi_scene;
mod wavelet_tex;
mod ycocg_fb;
