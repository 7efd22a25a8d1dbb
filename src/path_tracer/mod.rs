//! Path tracing on the CPU: the light that others are compared with.
//!
//! Surfaces are Lambertian, and may have a specular lobe of GGX microfacets besides. Next-event estimation samples the lights at each point of a path: all point and directional
//! ones, and a point of the emissive surfaces, which paths hit by chance, too, with the weights of multiple importance
//! sampling (balance heuristic: E. Veach, *Robust Monte Carlo Methods for Light Transport Simulation*, 1997,
//! section 9.2.2). Rays that leave the scene hit the sky. Russian roulette ends paths. The same settings give the same picture on any number of
//! threads.

pub use crate::path_tracer::{
    gloss::Gloss,
    tracer::{
        Hit, LightSample, Ray, Receiver, Surfaces, TraceSettings, TracedPicture, View, trace,
        trace_receivers,
    },
};

mod gloss;
mod tracer;
