"""Blender's Cycles on the scenes of benches/scenes.py, through the module bpy; compare.py runs this.

    python benches/peer_cycles.py worker                      requests as JSON lines on standard input
    python benches/peer_cycles.py picture FILE.json SIZE SPP OUT.png

Requests and answers are peer_mitsuba.py's. What is timed is Blender's render operator with the scene and its
hierarchy kept from an earlier picture (`use_persistent_data`), the writing of a file of plain float32 (a few
milliseconds) included; the first picture of a scene is thrown away.
Nothing biased is on: no clamping, no blurred gloss, no adaptive sampling, no denoiser. The pixel filter is a box or
Snell's Blackman-Harris window, by which Cycles places samples; its width is half of the window's.
Materials come from the .glb through Blender's importer; what it adds that glTF's model lacks is taken away
(multiple scattering; volumes of solids that absorb nothing).
"""

import json
import resource
import sys
import time
from pathlib import Path

import bpy
import numpy as np

# Counted after the camera's vertex: Snell's --max-depth 7, Mitsuba's max_depth 8.
BOUNCES = 6
FILTERS = dict(box=("BOX", 1.0), wide=("BLACKMAN_HARRIS", 1.5))


def fix_materials():
    for material in bpy.data.materials:
        if not material.node_tree:
            continue
        for node in material.node_tree.nodes:
            if node.type == "BSDF_PRINCIPLED":
                node.distribution = "GGX"
            if node.type == "OUTPUT_MATERIAL":
                for link in list(node.inputs["Volume"].links):
                    material.node_tree.links.remove(link)
        material.cycles.emission_sampling = "FRONT" if material.name.startswith("light") else "NONE"


def make_world(env, folder):
    world = bpy.data.worlds.new("world")
    bpy.context.scene.world = world
    world.use_nodes = True
    tree = world.node_tree
    color = tree.nodes["Background"].inputs["Color"]
    if env is not True:
        color.default_value = (*(env or [0, 0, 0]), 1)
        return
    sky = tree.nodes.new("ShaderNodeTexEnvironment")
    sky.image = bpy.data.images.load(str((folder / "env.hdr").resolve()))
    sky.image.colorspace_settings.name = "Linear Rec.709"
    tree.links.new(sky.outputs["Color"], color)
    world.cycles.sampling_method = "MANUAL"
    world.cycles.sample_map_resolution = 512


def load(file, size, pixel_filter):
    file = Path(file)
    s = json.loads(file.read_text())
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=str(file.parent / s.get("gltf", f"{file.stem}.glb")))
    scene = bpy.context.scene
    scene.camera = next(o for o in bpy.data.objects if o.type == "CAMERA")
    fix_materials()
    make_world(s["env"], file.parent)
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x = render.resolution_y = size
    render.resolution_percentage = 100
    render.use_persistent_data = True
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = cycles.use_denoising = cycles.use_fast_gi = False
    cycles.pixel_filter_type, cycles.filter_width = FILTERS[pixel_filter]
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    for kind in ("max", "diffuse", "glossy", "transmission", "transparent_max"):
        setattr(cycles, f"{kind}_bounces", BOUNCES)
    return scene


def write_as(scene, format, depth, view):
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_mode, settings.color_depth = format, "RGB", depth
    settings.exr_codec = "NONE"
    scene.view_settings.view_transform = view


def read_exr(path):
    import OpenEXR

    with OpenEXR.File(str(path)) as file:
        channels = file.channels()
        if "RGB" in channels:
            return np.array(channels["RGB"].pixels, np.float32)
        return np.stack([channels[c].pixels for c in "RGB"], -1).astype(np.float32)


def render(scene, spp, seed, out):
    """Into a file without compression: a result that is saved afterwards may be an earlier picture's."""
    scene.cycles.samples, scene.cycles.seed = spp, seed
    scene.render.filepath = out
    start, processor = time.perf_counter(), resource.getrusage(resource.RUSAGE_SELF)
    bpy.ops.render.render(write_still=True)
    seconds, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_SELF)
    used = after.ru_utime + after.ru_stime - processor.ru_utime - processor.ru_stime
    return dict(seconds=seconds, processor_seconds=used)


def worker():
    loaded, scene = None, None
    for line in sys.stdin:
        request = json.loads(line)
        if "version" in request:
            print("ANSWER " + json.dumps(dict(version=bpy.app.version_string)), flush=True)
            continue
        exr = f"{request['out']}.exr"
        wanted = request["scene"], request["size"], request["filter"]
        if wanted != loaded:
            scene = load(*wanted)
            write_as(scene, "OPEN_EXR", "32", "Raw")
            loaded = wanted
            render(scene, 1, 0, exr)
        answer = render(scene, request["spp"], request["seed"], exr)
        np.save(request["out"], read_exr(exr))
        Path(exr).unlink()
        print("ANSWER " + json.dumps(answer), flush=True)


def picture(file, size, spp, out):
    scene = load(file, int(size), "box")
    write_as(scene, "PNG", "8", "Standard")
    scene.render.filepath = str(Path(out).resolve())
    scene.cycles.samples = int(spp)
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    if sys.argv[1] == "worker":
        worker()
    else:
        picture(*sys.argv[2:])
