"""How far Snell goes: large scenes and pictures, their memory and times; and time per ray against triangles.

    python benches/scale.py limits [CASE ...]     a table of stage times and memory
    python benches/scale.py rays                  benches/time_per_ray.svg and its numbers

Both take --snell PROGRAM, --icd FILE.json (another Vulkan driver), --folder FOLDER for the scenes (up to 2 GB), and
print Markdown. Memory is the largest resident set of the process, which holds a software adapter's copy too. Needs
numpy; the textures of `textures` also zlib's pictures, made here.
"""

import argparse
import json
import math
import os
import statistics
import struct
import subprocess
import sys
import time
import zlib
from pathlib import Path

import numpy as np

import scenes

HERE = Path(__file__).resolve().parent
SVG = HERE / "time_per_ray.svg"


# ---- scenes


def land(triangles):
    """The landscape of scenes.py's `million`, under the sky."""
    s = scenes.million()
    n = max(1, round(math.sqrt(triangles / 2)))
    s.meshes, s.nodes = dict(land=scenes.landscape(n, 9.0, seed=4)), []
    s.add("land", "earth")
    return s


def write_land(path, triangles):
    scenes.write_glb(path, land(triangles))
    return dict(env="env.hdr")


def document(glb, camera, meshes, nodes, materials, **more):
    """Closes a .glb of one scene whose last node is the camera."""
    nodes = [*nodes, dict(camera=0, matrix=scenes.column_major(scenes.camera_node(camera)))]
    glb.close(
        dict(
            scenes=[dict(nodes=list(range(len(nodes))))], nodes=nodes, meshes=meshes,
            cameras=[scenes.gltf_camera(camera)], materials=materials, **more,
        )
    )  # fmt: skip


def add_mesh(glb, mesh, material, uv=None):
    attributes = dict(
        POSITION=glb.array(mesh.positions.astype("float32"), "VEC3", bounds=True),
        NORMAL=glb.array(mesh.normals.astype("float32"), "VEC3"),
    )
    if uv is not None:
        attributes["TEXCOORD_0"] = glb.array(uv.astype("float32"), "VEC2")
    indices = glb.array(mesh.triangles.astype("uint32").ravel(), "SCALAR")
    return dict(primitives=[dict(attributes=attributes, indices=indices, material=material)])


GRAY = dict(pbrMetallicRoughness=dict(baseColorFactor=[0.6, 0.6, 0.6, 1.0], metallicFactor=0.0, roughnessFactor=0.8))


def write_instances(path, count):
    """A cloud of small turned tetrahedra (EXT_mesh_gpu_instancing)."""
    rng = np.random.default_rng(7)
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], float)
    faces = np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
    glb = scenes.Glb(path)
    mesh = add_mesh(glb, scenes.smooth(corners, faces), 0)
    turns = rng.normal(size=(count, 4))
    attributes = dict(
        TRANSLATION=glb.array(rng.uniform(-100, 100, (count, 3)).astype("float32"), "VEC3"),
        ROTATION=glb.array((turns / np.linalg.norm(turns, axis=1, keepdims=True)).astype("float32"), "VEC4"),
        SCALE=glb.array(rng.uniform(0.2, 0.6, (count, 1)).repeat(3, 1).astype("float32"), "VEC3"),
    )
    node = dict(mesh=0, extensions=dict(EXT_mesh_gpu_instancing=dict(attributes=attributes)))
    document(glb, dict(origin=[0, 60, 260], target=[0, 0, 0], yfov=50.0), [mesh], [node], [GRAY])
    return dict(env="env.hdr")


def png(side, number):
    """An 8-bit RGB picture that compresses well and differs from pixel to pixel."""
    x = np.arange(side, dtype=np.uint8)
    row = np.stack([x, x + number, 255 - x], 1).astype(np.uint8).tobytes()
    raw = b"".join(b"\0" + row[3 * (y % 16) :] + row[: 3 * (y % 16)] for y in range(side))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(raw, 1)) + chunk(b"IEND", b"")


def write_textures(path, gibibytes):
    """A wall of quads, each with a picture of 4096 x 4096 of its own: 64 MiB on the device."""
    count = round(gibibytes * 16)
    across = math.ceil(math.sqrt(count))
    glb, meshes, images = scenes.Glb(path), [], []
    uv = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], float)
    for number in range(count):
        x, y = number % across, number // across
        wall = scenes.quad((x, y, 0), (x + 0.95, y, 0), (x + 0.95, y + 0.95, 0), (x, y + 0.95, 0))
        meshes.append(add_mesh(glb, wall, number, uv))
        images.append(dict(bufferView=glb.file(png(4096, number)), mimeType="image/png"))
    materials = [
        dict(pbrMetallicRoughness=dict(baseColorTexture=dict(index=i), metallicFactor=0.0)) for i in range(count)
    ]
    middle = across / 2
    camera = dict(origin=[middle, middle, 1.5 * across], target=[middle, middle, 0], yfov=40.0)
    more = dict(textures=[dict(source=i) for i in range(count)], images=images)
    document(glb, camera, meshes, [dict(mesh=i) for i in range(count)], materials, **more)
    return dict(env="1,1,1")


def floor():
    return scenes.quad((-50, 0, 50), (50, 0, 50), (50, 0, -50), (-50, 0, -50))


def write_emitters(path, count):
    """Small glowing triangles over a floor, no two of one strength."""
    rng = np.random.default_rng(3)
    glb = scenes.Glb(path)
    low = rng.uniform([-40, 1, -40], [40, 4, 40], (count, 3))
    p = np.stack([low, low + [0.3, 0, 0], low + [0, 0, 0.3]], 1).reshape(-1, 3)
    triangles = np.arange(3 * count).reshape(-1, 3)
    bands = 8
    meshes = [add_mesh(glb, floor(), 0)]
    for band in range(bands):
        own = triangles[band::bands]
        mesh = scenes.Mesh(p[own].reshape(-1, 3), np.tile([0.0, -1, 0], (own.size, 1)), np.arange(own.size).reshape(-1, 3))
        meshes.append(add_mesh(glb, mesh, 1 + band))
    glows = [
        dict(
            emissiveFactor=[1.0, 0.8, 0.3 + 0.08 * band],
            extensions=dict(KHR_materials_emissive_strength=dict(emissiveStrength=2.0**band)),
        )
        for band in range(bands)
    ]
    camera = dict(origin=[0, 25, 60], target=[0, 0, 0], yfov=50.0)
    document(glb, camera, meshes, [dict(mesh=i) for i in range(len(meshes))], [GRAY, *glows])
    return {}


def write_punctual(path, count):
    rng = np.random.default_rng(5)
    glb = scenes.Glb(path)
    lights = [dict(type="point", intensity=float(i), color=[1.0, 0.9, 0.7]) for i in rng.uniform(1, 60, count)]
    nodes = [
        dict(translation=t, extensions=dict(KHR_lights_punctual=dict(light=i)))
        for i, t in enumerate(rng.uniform([-45, 1, -45], [45, 4, 45], (count, 3)).tolist())
    ]
    camera = dict(origin=[0, 25, 60], target=[0, 0, 0], yfov=50.0)
    more = dict(extensions=dict(KHR_lights_punctual=dict(lights=lights)))
    document(glb, camera, [add_mesh(glb, floor(), 0)], [dict(mesh=0), *nodes], [GRAY], **more)
    return {}


def small(path, _):
    """A large picture of a little: what is measured is the film and its way into a file."""
    scenes.write_glb(path, scenes.cornell())
    return dict(options=["--max-depth", "0"])


# Name: writer, how many of what it is about, size, samples, ending.
CASES = {
    "triangles": (write_land, 10_000_000, "256x256", 4, "png"),
    "instances": (write_instances, 1_000_000, "256x256", 4, "png"),
    "picture-png": (small, 8192, "8192x8192", 1, "png"),
    "picture-exr": (small, 8192, "8192x8192", 1, "exr"),
    "textures": (write_textures, 2, "256x256", 4, "png"),
    "emitters": (write_emitters, 10_000, "256x256", 16, "png"),
    "punctual": (write_punctual, 1_000, "256x256", 16, "png"),
}


# ---- runs


def render(arguments, path, light, size, spp, out, options=()):
    """The report of a render, or the sentence that it ended with."""
    record = out.with_suffix(".report.json")
    command = [arguments.snell, "render", str(path), "-o", str(out), "--size", size, "--spp", str(spp), "--quiet"]
    command += ["--max-memory", arguments.max_memory, "--report", str(record), *options]
    if "env" in light:
        env = light["env"]
        command += ["--env", str(path.parent / env) if env.endswith(".hdr") else env]
    command += light.get("options", [])
    environment = dict(os.environ)
    if arguments.icd:
        environment.update(VK_ICD_FILENAMES=arguments.icd, VK_DRIVER_FILES=arguments.icd)
    start = time.perf_counter()
    process = subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True)
    used = [(0.0, 0.0)]
    while process.poll() is None:
        if seconds := processor_seconds(process.pid):
            used.append((time.perf_counter() - start, seconds))
        time.sleep(0.02)
    if process.returncode != 0:
        return f"status {process.returncode}: {process.stderr.read().strip()}"
    report = json.loads(record.read_text())
    times = report["times_ms"]
    before = sum(times.get(stage) or 0 for stage in ("load", "pack", "open_adapter", "upload", "compile")) / 1e3
    ends = np.interp([before, before + times["render"] / 1e3], *zip(*used))
    report["render_processor_s"] = float(ends[1] - ends[0])
    return report


def processor_seconds(pid):
    """What a running process has used so far, by all its threads."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return None
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def scene(arguments, name, write, number):
    """Writes the scene where it is not there yet."""
    path = arguments.folder / f"{name}_{number}.glb"
    light = path.with_suffix(".light.json")
    if not light.exists():
        light.write_text(json.dumps(write(path, number)))
    return path, json.loads(light.read_text())


def limits(arguments):
    stages = ["load", "pack", "upload", "compile", "render", "encode"]
    print(f"| case | renderer | {' | '.join(f'{s}, s' for s in stages)} | packed, MiB | bytes each | peak, MiB |")
    print("|" + " --- |" * (len(stages) + 5))
    for name in arguments.cases or CASES:
        write, number, size, spp, ending = CASES[name]
        path, light = scene(arguments, name, write, number)
        for renderer, options in (("adapter", []), ("--cpu", ["--cpu"])):
            report = render(arguments, path, light, size, spp, arguments.folder / f"{name}.{ending}", options)
            if isinstance(report, str):
                print(f"| {name} | {renderer} | {report} |")
                continue
            times, memory = report["times_ms"], report["memory"]
            packed = sum(memory["packed"].values()) - memory["packed"]["environment"] - memory["packed"]["environment_cells"]
            cells = [f"{(times.get(s) or 0) / 1e3:.2f}" for s in stages]
            cells += [f"{packed / 2**20:.0f}", f"{packed / number:.1f}", f"{memory['peak_resident'] / 2**20:.0f}"]
            print(f"| {name} | {renderer} | {' | '.join(cells)} |", flush=True)


def rays(arguments):
    """Processor time of the whole render, shading included, over its rays; the scene's only change is how fine its
    mesh is. Processor time, since other work on the machine spoils it least."""
    counts = [2 * round(math.sqrt(10**k / 2)) ** 2 for k in range(2, arguments.most + 1)]
    series = {"adapter": [], "--cpu": ["--cpu"]}
    found = {name: {count: [] for count in counts} for name in series}
    for _ in range(arguments.rounds):
        for count in counts:
            path, light = scene(arguments, "land", write_land, count)
            for name, options in series.items():
                report = render(arguments, path, light, "512x512", arguments.spp, arguments.folder / "land.png", options)
                if isinstance(report, str):
                    print(f"{count} triangles, {name}: {report}", file=sys.stderr)
                    continue
                traced = report["rays"]["closest"] + report["rays"]["shadow"]
                found[name][count].append(report["render_processor_s"] * 1e9 / traced)
    medians = {
        name: [(count, statistics.median(times)) for count, times in rows.items() if times]
        for name, rows in found.items()
    }
    print("| triangles | " + " | ".join(f"{name}, ns a ray" for name in medians) + " |")
    print("|" + " --- |" * (1 + len(medians)))
    for count in counts:
        cells = [f"{dict(rows)[count]:.0f}" if count in dict(rows) else "-" for rows in medians.values()]
        print(f"| {count} | {' | '.join(cells)} |")
    SVG.write_text(chart(medians))


def chart(medians):
    """An SVG: triangles on a logarithmic axis, nanoseconds a ray on a linear one, with the straight line that fits
    each series best: what grows with the logarithm lies on it."""
    width, height, left, bottom, top, right = 640, 400, 70, 50, 20, 150
    most = max(y for rows in medians.values() for _, y in rows)
    step = 10 ** math.floor(math.log10(most))
    step = next(s for s in (step / 5, step / 2, step, 2 * step) if most / s <= 6)
    ceiling = math.ceil(most / step) * step

    def at(count, ns):
        x = left + (math.log10(count) - 2) / 5 * (width - left - right)
        return x, height - bottom - ns / ceiling * (height - bottom - top)

    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="13">',
        f'<rect width="{width}" height="{height}" fill="white"/>',
    ]

    def text(x, y, words, anchor="middle", extra=""):
        parts.append(f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{extra}>{words}</text>')

    def line(x1, y1, x2, y2, stroke, extra=""):
        parts.append(f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{stroke}"{extra}/>')

    for k in range(2, 8):
        x, y = at(10**k, 0)
        line(x, y, x, top, "#ddd")
        text(x, y + 18, f'10<tspan dy="-5" font-size="10">{k}</tspan>')
    for k in range(round(ceiling / step) + 1):
        x, y = at(100, k * step)
        line(x, y, width - right, y, "#ddd")
        text(x - 6, y + 4, f"{k * step:g}", "end")
    text((left + width - right) / 2, height - 10, "triangles")
    middle = (top + height - bottom) / 2
    text(18, middle, "processor nanoseconds a ray", extra=f' transform="rotate(-90 18 {middle})"')
    for (name, rows), color in zip(medians.items(), ("#1b6ca8", "#c0561f")):
        slope, start = np.polyfit([math.log10(c) for c, _ in rows], [y for _, y in rows], 1)
        ends = [at(c, start + slope * math.log10(c)) for c in (rows[0][0], rows[-1][0])]
        line(*ends[0], *ends[1], color, ' stroke-dasharray="4 4"')
        for count, ns in rows:
            x, y = at(count, ns)
            parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{color}"/>')
        text(ends[1][0] + 12, ends[1][1] - 4, name, "start", f' fill="{color}"')
        text(ends[1][0] + 12, ends[1][1] + 12, f"{slope:+.0f} for each 10 x", "start", f' fill="{color}"')
    return "\n".join([*parts, "</svg>"]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("measure", choices=["limits", "rays"])
    parser.add_argument("cases", nargs="*", help=f"of {', '.join(CASES)}")
    parser.add_argument("--snell", default=str(HERE.parent / "target" / "release" / "snell"))
    parser.add_argument("--icd", metavar="FILE.json")
    parser.add_argument("--folder", type=Path, default=HERE.parent / "target" / "scale")
    parser.add_argument("--max-memory", default="16G")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--spp", type=int, default=4, help="of the pictures of `rays`")
    parser.add_argument("--most", type=int, default=7, help="`rays` goes up to 10 to this many triangles")
    arguments = parser.parse_args()
    if unknown := set(arguments.cases) - set(CASES):
        parser.error(f"no case {', '.join(unknown)}; there are {', '.join(CASES)}")
    arguments.folder.mkdir(parents=True, exist_ok=True)
    scenes.write_hdr(arguments.folder / "env.hdr", scenes.sky())
    (limits if arguments.measure == "limits" else rays)(arguments)


if __name__ == "__main__":
    main()
