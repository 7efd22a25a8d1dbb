//! Path tracing on the CPU: the light that others are compared with.
//!
//! Surfaces are Lambertian. Point and directional lights are sampled at each point of a path; emissive
//! surfaces are sampled too and found by chance, with the weights of multiple importance sampling (balance
//! heuristic: E. Veach, *Robust Monte Carlo Methods for Light Transport Simulation*, 1997, section 9.2.2);
//! the sky is what rays find that leave the scene. The same settings give the same picture on any number of
//! threads.

pub use crate::path_tracer::tracer::{
    EmitterPoint, Hit, Ray, Receiver, Surfaces, TraceSettings, TracedPicture, View, trace,
    trace_receivers,
};

mod tracer;
