//! The voxel GI in pictures.

mod basics;
mod changes;
mod colors;
mod devices;
mod extremes;
mod fixture;
mod games;
mod history;
mod light_textures;
mod materials;
mod moving;
mod options;
mod rays;
mod receiver;
mod reference;
mod room;
mod specular;
mod surfaces;
mod truth;
mod volumes;
mod world;
