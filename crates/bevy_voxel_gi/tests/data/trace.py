"""Path-traces the indirect and direct light of scenes of boxes with Mitsuba.

    pip install mitsuba==3.9.0 numpy
    python trace.py [--samples 2048] SCENE.json...

writes SCENE.indirect.npy and SCENE.direct.npy beside each scene; README.md describes their content.
"""

import argparse
import json
import pathlib

import mitsuba
import numpy

mitsuba.set_variant("scalar_rgb")
Transform = mitsuba.ScalarTransform4f

# Edge in pixels of the blocks over which radiance is averaged.
BLOCK = 4
# Maximum number of segments of a path, the camera ray included.
DEPTH = 24
# Segment from which Russian roulette may end a path; 50 disables it.
ROULETTE = 50


def build(scene, sky):
    """Mitsuba's scene, with or without its sky."""
    result = {"type": "scene"}
    for i, box in enumerate(scene["boxes"]):
        pose = Transform().translate(box["center"])
        pose = pose @ Transform().rotate([0, 1, 0], box.get("rotate_y_deg", 0))
        reflectance = {"type": "rgb", "value": box["albedo"]}
        result[f"box{i}"] = {
            "type": "cube",
            "to_world": pose @ Transform().scale(box["half"]),
            "bsdf": {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": reflectance}},
        }
    for i, light in enumerate(scene.get("point_lights", [])):
        intensity = {"type": "rgb", "value": light["intensity_cd"]}
        result[f"point{i}"] = {"type": "point", "position": light["position"], "intensity": intensity}
    for i, light in enumerate(scene.get("directional_lights", [])):
        irradiance = {"type": "rgb", "value": light["illuminance_lux"]}
        result[f"directional{i}"] = {
            "type": "directional",
            "direction": light["direction"],
            "irradiance": irradiance,
        }
    if sky and scene.get("sky_radiance"):
        radiance = {"type": "rgb", "value": scene["sky_radiance"]}
        result["sky"] = {"type": "constant", "radiance": radiance}
    camera = scene["camera"]
    look = Transform().look_at(origin=camera["eye"], target=camera["target"], up=camera["up"])
    result["sensor"] = {
        "type": "perspective",
        "fov_axis": "y",
        "fov": camera["fov_y_deg"],
        "to_world": look,
        "film": {
            "type": "hdrfilm",
            "width": camera["width"],
            "height": camera["height"],
            "pixel_format": "rgb",
            "component_format": "float32",
            "rfilter": {"type": "box"},
        },
        "sampler": {"type": "independent"},
    }
    return mitsuba.load_dict(result)


def render(scene, integrator, samples):
    picture = mitsuba.render(scene, integrator=mitsuba.load_dict(integrator), spp=samples, seed=7)
    return numpy.array(picture, dtype=numpy.float32)


def path(depth):
    return {"type": "path", "max_depth": depth, "rr_depth": ROULETTE}


def block_means(picture, surface):
    """Means over blocks of pixels; 0 where a pixel of the block shows no surface."""
    height, width = surface.shape[0] // BLOCK, surface.shape[1] // BLOCK
    shape = (height, BLOCK, width, BLOCK, -1)
    complete = surface.reshape(shape).all((1, 3))
    return (picture.reshape(shape).mean((1, 3)) * complete).astype("<f4")


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    arguments.add_argument("--samples", type=int, default=2048, help="number of paths per pixel")
    arguments.add_argument("scenes", nargs="+", type=pathlib.Path)
    arguments = arguments.parse_args()
    for file in arguments.scenes:
        scene = json.loads(file.read_text())
        lamps, complete = build(scene, sky=False), build(scene, sky=True)
        direct = render(lamps, path(2), arguments.samples)
        total = render(complete, path(DEPTH), arguments.samples)
        depth = render(lamps, {"type": "aov", "aovs": "depth:depth"}, 16)[..., :1]
        indirect = numpy.maximum(total - direct, 0)
        for name, picture in (("indirect", indirect), ("direct", direct)):
            numpy.save(file.with_suffix(f".{name}.npy"), block_means(picture, depth > 0))
        print(f"{file.stem}: mean indirect {indirect.mean():.4g}, direct {direct.mean():.4g}")


main()
