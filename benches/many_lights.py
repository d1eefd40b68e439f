"""Writes many_triangles.glb (10^4 emissive triangles) and many_points.glb (10^3 point lights) into a folder:
a floor of 40 m with 400 blocks on it and the lights scattered between and above them, powers spread over a
factor of 100. Usage: python3 many_lights.py FOLDER
"""

import json
import random
import struct
import sys
from pathlib import Path

SIDE = 40.0  # metres
BLOCKS = 20  # a side
TRIANGLES = 10_000
POINTS = 1_000
BOX = [(x, y, z) for x in (-1, 1) for y in (0, 2) for z in (-1, 1)]
BOX_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def blocks(rng):
    """Floor and blocks, as separate triangles."""
    half = SIDE / 2
    corners = [(-half, 0, -half), (-half, 0, half), (half, 0, half), (half, 0, -half)]
    triangles = [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
    for i in range(BLOCKS):
        for j in range(BLOCKS):
            x = (i + rng.uniform(0.3, 0.7)) * SIDE / BLOCKS - half
            z = (j + rng.uniform(0.3, 0.7)) * SIDE / BLOCKS - half
            width, height = rng.uniform(0.2, 0.6), rng.uniform(0.2, 1.5)
            box = [(x + width * a, height * b, z + width * c) for a, b, c in BOX]
            for a, b, c, d in BOX_FACES:
                triangles += [[box[a], box[b], box[c]], [box[a], box[c], box[d]]]
    return triangles


def place(rng):
    return [rng.uniform(-SIDE / 2, SIDE / 2), rng.uniform(0.2, 3.5), rng.uniform(-SIDE / 2, SIDE / 2)]


def write(path, meshes, materials, lights):
    """`meshes`: per material a list of triangles. `lights`: (position, intensity in candela)."""
    data, views, accessors, primitives = b"", [], [], []
    for material, triangles in enumerate(meshes):
        points = [p for triangle in triangles for p in triangle]
        if not points:
            continue
        packed = b"".join(struct.pack("<3f", *p) for p in points)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(packed)})
        low, high = [[float(f(p[k] for p in points)) for k in range(3)] for f in (min, max)]
        accessors.append({
            "bufferView": len(views) - 1, "componentType": 5126, "count": len(points), "type": "VEC3",
            "min": [struct.unpack("<f", struct.pack("<f", x))[0] for x in low],
            "max": [struct.unpack("<f", struct.pack("<f", x))[0] for x in high],
        })
        primitives.append({"attributes": {"POSITION": len(accessors) - 1}, "material": material})
        data += packed
    # Looks down into the scene from a corner.
    nodes = [{"mesh": 0}, {"camera": 0, "translation": [0, 9, 24], "rotation": [-0.2588190451, 0, 0, 0.9659258263]}]
    nodes += [
        {"translation": p, "extensions": {"KHR_lights_punctual": {"light": i}}} for i, (p, _) in enumerate(lights)
    ]
    gltf = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes,
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "aspectRatio": 1.0, "znear": 0.1}}],
        "meshes": [{"primitives": primitives}], "materials": materials, "buffers": [{"byteLength": len(data)}],
        "bufferViews": views, "accessors": accessors,
        "extensionsUsed": ["KHR_materials_emissive_strength", "KHR_lights_punctual"],
    }
    if lights:
        gltf["extensions"] = {
            "KHR_lights_punctual": {"lights": [{"type": "point", "intensity": cd} for _, cd in lights]}
        }
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    total = 28 + len(text) + len(data)
    path.write_bytes(
        struct.pack("<4sII", b"glTF", 2, total) + struct.pack("<I4s", len(text), b"JSON") + text
        + struct.pack("<I4s", len(data), b"BIN\0") + data
    )


def main(folder):
    rng = random.Random(5)
    ground = blocks(rng)
    grey = {"pbrMetallicRoughness": {"baseColorFactor": [0.6, 0.6, 0.6, 1], "metallicFactor": 0, "roughnessFactor": 0.8}}
    materials, meshes = [grey], [ground]
    for strength in (10.0, 100.0, 1000.0):
        color = [rng.uniform(0.3, 1.0) for _ in range(3)]
        materials.append({
            "emissiveFactor": color, "doubleSided": True,
            "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]},
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": strength}},
        })
        meshes.append([])
    for i in range(TRIANGLES):
        p = place(rng)
        corner = lambda: [x + rng.uniform(-0.05, 0.05) for x in p]
        # Few bright ones: 60, 30 and 10 of a hundred.
        meshes[1 + (i % 10 > 5) + (i % 10 > 8)].append([corner(), corner(), corner()])
    write(folder / "many_triangles.glb", meshes, materials, [])
    lights = [(place(rng), 10 ** rng.uniform(1, 3)) for _ in range(POINTS)]
    write(folder / "many_points.glb", meshes[:1], materials[:1], lights)


main(Path(sys.argv[1]))
