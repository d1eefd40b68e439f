"""A textured glTF asset for all three renderers; compare.py's --asset uses this.

`prepare(FILE.gltf, FOLDER)` writes into FOLDER
    the file and what lies beside it, with a camera that frames it, for renderers that read glTF
    STEM.json, .ply and single-channel .png, for Mitsuba, which does not

and returns STEM.json. Only what common assets of the metallic-roughness model hold is understood: separate
buffers, float attributes, one texture set, no node matrices. `env` is a radiance from all around, or True for the
sky beside it. Needs numpy, pillow.
"""

import json
import math
import shutil
from pathlib import Path

import numpy as np

import scenes

YFOV = 40.0


def accessor(gltf, folder, index):
    a = gltf["accessors"][index]
    view = gltf["bufferViews"][a["bufferView"]]
    kind = {5121: "<u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}[a["componentType"]]
    width = dict(SCALAR=1, VEC2=2, VEC3=3, VEC4=4)[a["type"]]
    stride = view.get("byteStride", width * np.dtype(kind).itemsize)
    data = (folder / gltf["buffers"][view["buffer"]]["uri"]).read_bytes()
    start = view.get("byteOffset", 0) + a.get("byteOffset", 0)
    rows = np.ndarray((a["count"], width), kind, data, start, (stride, np.dtype(kind).itemsize))
    return rows.copy()


def frame(low, high):
    """A camera before the box's front that sees all of it in a square picture."""
    center, half = (low + high) / 2, (high - low) / 2
    back = 1.1 * max(half[0], half[1]) / math.tan(math.radians(YFOV / 2)) + half[2]
    return dict(origin=(center + [0, 0, back]).tolist(), target=center.tolist(), yfov=YFOV)


def channel(image, number, out):
    if not out.exists():
        from PIL import Image

        Image.open(image).convert("RGBA").getchannel(number).save(out, icc_profile=None)
    return out.name


def plain_material(gltf, m, folder):
    def file(texture):
        return gltf["images"][gltf["textures"][texture["index"]]["source"]]["uri"]

    pbr = m["pbrMetallicRoughness"]
    orm, base = file(pbr["metallicRoughnessTexture"]), file(pbr["baseColorTexture"])
    out = dict(
        kind="textured",
        base_color=base,
        roughness=channel(folder / orm, 1, folder / f"{orm}.roughness.png"),
        metallic=channel(folder / orm, 2, folder / f"{orm}.metallic.png"),
        normal=file(m["normalTexture"]),
    )
    if m.get("alphaMode", "OPAQUE") != "OPAQUE":
        out["opacity"] = channel(folder / base, 3, folder / f"{base}.opacity.png")
    return out


def prepare(source, folder, env=(1.0, 1.0, 1.0)):
    source, folder = Path(source), Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for file in source.parent.iterdir():
        if file.is_file():
            shutil.copyfile(file, folder / file.name)
    gltf = json.loads(source.read_text())
    materials = {str(i): plain_material(gltf, m, folder) for i, m in enumerate(gltf["materials"])}
    nodes, count, low, high = [], 0, np.full(3, np.inf), np.full(3, -np.inf)
    for i, node in enumerate(gltf["nodes"]):
        if {"matrix", "rotation", "scale", "translation", "children"} & set(node):
            raise SystemExit(f"{source}: nodes[{i}] is transformed, which benches/asset.py does not understand")
        for j, primitive in enumerate(gltf["meshes"][node["mesh"]]["primitives"]):
            use = primitive["attributes"]
            positions, normals, uv = (accessor(gltf, folder, use[k]) for k in ("POSITION", "NORMAL", "TEXCOORD_0"))
            triangles = accessor(gltf, folder, primitive["indices"]).reshape(-1, 3).astype(int)
            mesh, name = scenes.Mesh(positions, normals, triangles), f"{source.stem}_{i}_{j}.ply"
            scenes.write_ply(folder / name, mesh, uv)
            nodes.append(dict(mesh=name, material=str(primitive["material"]), matrix=np.eye(4).tolist()))
            count += len(triangles)
            low, high = np.minimum(low, positions.min(0)), np.maximum(high, positions.max(0))
    camera = frame(low, high)
    gltf["cameras"] = [scenes.gltf_camera(camera)]
    gltf["nodes"].append(dict(name="camera", camera=0, matrix=scenes.column_major(scenes.camera_node(camera))))
    gltf["scenes"][gltf.get("scene", 0)]["nodes"].append(len(gltf["nodes"]) - 1)
    (folder / source.name).write_text(json.dumps(gltf))
    plain = dict(triangles=count, gltf=source.name, materials=materials, camera=camera, env=env, nodes=nodes)
    out = folder / f"{source.stem}.json"
    out.write_text(json.dumps(plain))
    return out
