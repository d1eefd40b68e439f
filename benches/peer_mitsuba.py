"""Mitsuba 3 on the scenes of benches/scenes.py; compare.py runs this.

    python benches/peer_mitsuba.py worker VARIANT             requests as JSON lines on standard input
    python benches/peer_mitsuba.py picture VARIANT FILE.json SIZE SPP OUT.png

A request is {"scene": FILE.json, "size", "spp", "seed", "filter", "out": FILE.npy}; the answer is a line of JSON after
"ANSWER ": seconds, processor_seconds. What is timed is `mi.render` until its pixels are in memory: no import, no
scene. The integrator is `path`, the sampler `independent`, the pixel filter a box or, of the width of Snell's, a
Gaussian: both weight a sample in all pixels that they reach.
"""

import json
import resource
import sys
import time
from pathlib import Path

import mitsuba as mi
import numpy as np

# Vertices of a path with camera and lamp, less one: Snell's --max-depth 7, Cycles' 6 bounces.
MAX_DEPTH = 8
# The standard deviation is that of a Blackman-Harris window 3 pixels wide.
FILTERS = dict(box=dict(type="box"), wide=dict(type="gaussian", stddev=0.4155))


def rgb(value):
    return dict(type="rgb", value=list(value))


def texture(file, raw):
    return dict(type="bitmap", filename=str(file), raw=raw)


def bsdf(m, folder):
    kind = m["kind"]
    if kind == "diffuse":
        return dict(type="twosided", below=dict(type="diffuse", reflectance=rgb(m["color"])))
    if kind == "light":
        return dict(type="diffuse", reflectance=rgb([0, 0, 0]))
    if kind == "glass":
        if m["roughness"] == 0:
            return dict(type="dielectric", int_ior=m["ior"], ext_ior=1.0)
        alpha = m["roughness"] ** 2
        return dict(type="roughdielectric", distribution="ggx", alpha=alpha, int_ior=m["ior"], ext_ior=1.0)
    if kind in ("metal", "plastic"):
        metallic = float(kind == "metal")
        principled = dict(
            type="principled", base_color=rgb(m["color"]), metallic=metallic, roughness=float(m["roughness"])
        )
        return dict(type="twosided", below=principled)
    if kind == "textured":
        principled = dict(
            type="principled",
            base_color=texture(folder / m["base_color"], raw=False),
            metallic=texture(folder / m["metallic"], raw=True),
            roughness=texture(folder / m["roughness"], raw=True),
        )
        bumped = dict(type="normalmap", normalmap=texture(folder / m["normal"], raw=True), below=principled)
        out = dict(type="twosided", below=bumped)
        if "opacity" in m:
            out = dict(type="mask", opacity=texture(folder / m["opacity"], raw=True), below=out)
        return out
    raise ValueError(f"no material of the kind {kind}")


def load(file, size, pixel_filter):
    file, turn = Path(file), mi.ScalarTransform4f
    s = json.loads(file.read_text())
    camera = s["camera"]
    film = dict(type="hdrfilm", width=size, height=size, pixel_format="rgb", component_format="float32")
    film["rfilter"] = FILTERS[pixel_filter]
    look = turn().look_at(origin=camera["origin"], target=camera["target"], up=[0, 1, 0])
    sensor = dict(
        type="perspective", fov=camera["yfov"], fov_axis="y", near_clip=0.01, far_clip=1e4, to_world=look,
        film=film, sampler=dict(type="independent"),
    )  # fmt: skip
    out = dict(type="scene", integrator=dict(type="path", max_depth=MAX_DEPTH), sensor=sensor)
    if s["env"] is True:
        # Mitsuba finds a direction at u = atan2(d.x, -d.z) / (2 pi), a quarter turn from the file's.
        quarter = turn().rotate([0, 1, 0], 90)
        out["env"] = dict(type="envmap", filename=str(file.parent / "env.hdr"), to_world=quarter)
    elif s["env"]:
        out["env"] = dict(type="constant", radiance=rgb(s["env"]))
    for number, node in enumerate(s["nodes"]):
        m = s["materials"][node["material"]]
        shape = dict(type="ply", filename=str(file.parent / node["mesh"]), bsdf=bsdf(m, file.parent))
        shape["to_world"] = turn(np.array(node["matrix"]))
        if m["kind"] == "light":
            shape["emitter"] = dict(type="area", radiance=rgb(m["radiance"]))
        out[f"shape{number}"] = shape
    return mi.load_dict(out)


def worker():
    loaded, scene = None, None
    for line in sys.stdin:
        request = json.loads(line)
        if "version" in request:
            print("ANSWER " + json.dumps(dict(version=mi.__version__)), flush=True)
            continue
        wanted = request["scene"], request["size"], request["filter"]
        if wanted != loaded:
            scene = load(*wanted)
            loaded = wanted
        start, processor = time.perf_counter(), resource.getrusage(resource.RUSAGE_SELF)
        image = np.array(mi.render(scene, spp=request["spp"], seed=request["seed"]))
        seconds, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_SELF)
        used = after.ru_utime + after.ru_stime - processor.ru_utime - processor.ru_stime
        np.save(request["out"], image.astype(np.float32))
        print("ANSWER " + json.dumps(dict(seconds=seconds, processor_seconds=used)), flush=True)


def picture(file, size, spp, out):
    mi.util.write_bitmap(out, mi.render(load(file, int(size), "box"), spp=int(spp)), write_async=False)


if __name__ == "__main__":
    mi.set_variant(sys.argv[2])
    if sys.argv[1] == "worker":
        worker()
    else:
        picture(*sys.argv[3:])
