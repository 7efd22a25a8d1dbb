//! Path tracing on the CPU: the light that others are compared with.
//!
//! Surfaces are Lambertian. Point and directional lights are sampled at each point of a path; emissive
//! surfaces are sampled too and found by chance, with the weights of multiple importance sampling (balance
//! heuristic: E. Veach, *Robust Monte Carlo Methods for Light Transport Simulation*, 1997, section 9.2.2);
//! the sky is what rays find that leave the scene. The same settings give the same picture on any number of
//! threads.
//!
//! | module | gives |
//! | --- | --- |
//! | `surfaces` | what a scene is for a path: rays, hits and points of emissive surfaces |
//! | `tracer` | paths |
//! | `picture` | the pictures |
//! | `receivers` | the light at points |
//! | `view` | the rays of a camera |
//! | `random` | numbers that look random |

mod picture;
mod random;
mod receivers;
mod surfaces;
mod tracer;
mod view;

pub use picture::{TracedPicture, trace};
pub use receivers::{Receiver, trace_receivers};
pub use surfaces::{EmitterPoint, Hit, Ray, Surfaces};
pub use tracer::TraceSettings;
pub use view::View;
