// The G-buffer, computed instead of stored: a ball on a floor. The same as surface.rs.
#define_import_path bevy_frugal_lab::deferred_accumulation::surface

#import bevy_render::view::View

@group(0) @binding(0) var<uniform> view: View;

// Centre and radius of the ball, in metres; it lies on the floor, the plane y = 0.
const BALL_CENTER = vec3(0.0, 0.6, 0.0);
const BALL_RADIUS: f32 = 0.6;
// Radius of the floor, in metres.
const FLOOR_RADIUS: f32 = 4.0;

struct Surface {
    position: vec3<f32>,
    normal: vec3<f32>,
    // Towards the eye.
    to_eye: vec3<f32>,
    albedo: vec3<f32>,
    // Whether there is any surface at all.
    exists: bool,
}

// What the pixel at this position of the target sees.
fn surface_at(position: vec2<f32>) -> Surface {
    let in_viewport = (position - view.viewport.xy) / view.viewport.zw;
    let ndc = vec2(2.0, -2.0) * in_viewport + vec2(-1.0, 1.0);
    let near = view.world_from_clip * vec4(ndc, 1.0, 1.0);
    let eye = view.world_position;
    let ray = normalize(near.xyz / near.w - eye);

    var surface: Surface;
    surface.to_eye = -ray;

    let from_ball = eye - BALL_CENTER;
    let b = dot(from_ball, ray);
    let discriminant = b * b - dot(from_ball, from_ball) + BALL_RADIUS * BALL_RADIUS;
    let to_ball = -b - sqrt(max(discriminant, 0.0));
    if discriminant > 0.0 && to_ball > 0.0 {
        surface.position = eye + to_ball * ray;
        surface.normal = (surface.position - BALL_CENTER) / BALL_RADIUS;
        surface.albedo = vec3(0.8);
        surface.exists = true;
        return surface;
    }
    let to_floor = -eye.y / ray.y;
    surface.position = eye + to_floor * ray;
    surface.normal = vec3(0.0, 1.0, 0.0);
    surface.albedo = vec3(0.5, 0.48, 0.45);
    surface.exists = ray.y < 0.0 && to_floor > 0.0 && length(surface.position.xz) < FLOOR_RADIUS;
    return surface;
}
