//! The voxel GI in pictures.

mod basics;
mod bounces;
mod budget;
mod changes;
mod colors;
mod contacts;
mod devices;
mod extremes;
mod games;
mod history;
mod materials;
mod memory;
mod moving;
mod rays;
mod receiver;
mod reference;
mod room;
mod round_robin;
mod scene;
mod specular;
mod stochastic;
mod support;
mod surfaces;
mod truth;
mod volumes;
mod world;
