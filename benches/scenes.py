"""The scenes that benches/compare.py renders.

    python benches/scenes.py FOLDER [SCENE ...]

writes for each scene
    SCENE.glb         glTF 2.0 with its camera, for renderers that read glTF
    SCENE.json        the same scene as plain data, meshes as .ply, for those that do not
and `env.hdr`, the sky of the scenes whose "env" is true. Needs numpy.

Frames: right-handed, y up, metres. The sky's columns follow Snell, three.js and Blender (after its turn of the
axes): a direction d is found at u = atan2(d.z, d.x) / (2 pi) + 1/2, v = acos(d.y) / pi from the top row.

`cornell` and `spheres` are the team's neutral scenes, `million` is a landscape of 1.2 million triangles under the
same sky, `glass` a box with clear and frosted glass under a lamp. `interior` is a room that the sky lights through a
window, `lamps` a floor among 96 lamps of many sizes and colours, `herd` 400 instances under the sky, `rings` gold
under a lamp with nothing around it.

Kinds of material, and what each becomes in glTF (alpha = roughness^2 in all renderers):
    diffuse   a Lambertian: metallic 0, roughness 1, specularFactor 0
    metal     GGX with base colour as F0: metallic 1
    plastic   a diffuse base under a dielectric of index 1.5: metallic 0
    glass     a white dielectric solid: transmission 1, ior, thickness 1
    light     black, emits from its front
"""

import json
import math
import struct
import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np


@dataclass
class Mesh:
    """Vertices: n x 3 positions and normals; triangles: m x 3 indices, counter-clockwise from outside."""

    positions: np.ndarray
    normals: np.ndarray
    triangles: np.ndarray


@dataclass
class Scene:
    """`nodes` are (mesh, material, world_from_mesh as 4 x 4); `camera` has origin, target, yfov in degrees."""

    camera: dict
    env: bool
    meshes: dict = field(default_factory=dict)
    materials: dict = field(default_factory=dict)
    nodes: list = field(default_factory=list)

    def add(self, mesh, material, world_from_mesh=None):
        self.nodes.append((mesh, material, np.eye(4) if world_from_mesh is None else world_from_mesh))

    def triangles(self):
        return sum(len(self.meshes[mesh].triangles) for mesh, _, _ in self.nodes)


# ---- shapes


def quad(*corners):
    """A parallelogram from four corners, counter-clockwise from its front."""
    p = np.array(corners, float)
    n = np.cross(p[1] - p[0], p[3] - p[0])
    return Mesh(p, np.tile(n / np.linalg.norm(n), (4, 1)), np.array([[0, 1, 2], [0, 2, 3]]))


def joined(meshes):
    first = np.cumsum([0] + [len(m.positions) for m in meshes])
    return Mesh(
        np.concatenate([m.positions for m in meshes]),
        np.concatenate([m.normals for m in meshes]),
        np.concatenate([m.triangles + f for m, f in zip(meshes, first)]),
    )


def cube():
    """[-1, 1]^3 with flat normals."""
    faces = []
    for axis in range(3):
        u, v = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
        for w in (np.eye(3)[axis], -np.eye(3)[axis]):
            s = u if w.sum() > 0 else -u  # keeps the corners counter-clockwise from outside
            faces.append(quad(w - s - v, w + s - v, w + s + v, w - s + v))
    return joined(faces)


def icosphere(level):
    """The unit sphere in 20 * 4^level triangles, with the sphere's normals."""
    g = (1 + 5**0.5) / 2
    p = np.array([[0, s, t * g] for s in (1, -1) for t in (1, -1)])
    p = np.concatenate([p, p[:, [2, 0, 1]], p[:, [1, 2, 0]]])
    # An icosahedron's faces are the triples of vertices at its edge's length, 2.
    near = np.abs(np.linalg.norm(p[:, None] - p[None], axis=-1) - 2) < 1e-6
    t = [
        (a, b, c)
        for a in range(12)
        for b in range(a + 1, 12)
        for c in range(b + 1, 12)
        if near[a, b] and near[b, c] and near[a, c]
    ]
    t = np.array([(a, b, c) if np.linalg.det(p[[a, b, c]]) > 0 else (a, c, b) for a, b, c in t])
    p = p / np.linalg.norm(p, axis=1, keepdims=True)
    for _ in range(level):
        edges = np.sort(np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]]), axis=1)
        key, which = np.unique(edges[:, 0] * len(p) + edges[:, 1], return_inverse=True)
        middle = p[key // len(p)] + p[key % len(p)]
        middle /= np.linalg.norm(middle, axis=1, keepdims=True)
        ab, bc, ca = (which.reshape(3, -1) + len(p))
        a, b, c = t.T
        p = np.concatenate([p, middle])
        t = np.concatenate([np.stack(x, 1) for x in [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]])
    return Mesh(p, p.copy(), t)


def smooth(positions, triangles):
    """With vertex normals that average the faces', by area."""
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    face = np.cross(b - a, c - a)
    n = np.stack(
        [sum(np.bincount(triangles[:, k], face[:, axis], len(positions)) for k in range(3)) for axis in range(3)], 1
    )
    return Mesh(positions, n / np.linalg.norm(n, axis=1, keepdims=True), triangles)


def waves(x, y, z, seed, octaves=5):
    """A bumpy function of place, about [-1, 1]; the same for the same seed."""
    rng = np.random.default_rng(seed)
    total = np.zeros_like(x)
    for octave in range(octaves):
        for _ in range(3):
            k = rng.normal(size=3) * 1.9**octave
            total += 0.35 * 0.5**octave * np.sin(k[0] * x + k[1] * y + k[2] * z + rng.uniform(0, 2 * math.pi))
    return total


def landscape(n, half, seed):
    """A square of 2 n^2 triangles, `half` metres each way, with hills that leave its middle flat."""
    g = np.linspace(-half, half, n + 1)
    z, x = (a.ravel() for a in np.meshgrid(g, g, indexing="ij"))
    rise = np.clip(np.hypot(x, z) / half, 0, 1) ** 2
    y = (0.05 + 1.8 * rise) * waves(x, 0 * x, z, seed) + 1.2 * rise
    i = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    t = np.concatenate([np.stack([i, i + n + 1, i + 1], 1), np.stack([i + 1, i + n + 1, i + n + 2], 1)])
    return smooth(np.stack([x, y, z], 1), t)


def boulder(level, bump, seed):
    ball = icosphere(level)
    r = 1 + bump * waves(*(3 * ball.positions.T), seed)
    return smooth(ball.positions * r[:, None], ball.triangles)


def torus(radius, thickness, around=96, across=48):
    """A ring about +y; `thickness` is its tube's radius."""
    n, m = around, across
    u, v = np.meshgrid(2 * math.pi * np.arange(n) / n, 2 * math.pi * np.arange(m) / m, indexing="ij")
    normals = np.stack([np.cos(v) * np.cos(u), np.sin(v), np.cos(v) * np.sin(u)], -1).reshape(-1, 3)
    middle = np.stack([radius * np.cos(u), 0 * u, radius * np.sin(u)], -1).reshape(-1, 3)
    i, j = np.arange(n)[:, None], np.arange(m)
    a, b, c, d = (
        ((i + di) % n * m + (j + dj) % m).ravel() for di, dj in ((0, 0), (0, 1), (1, 0), (1, 1))
    )
    return Mesh(
        middle + thickness * normals, normals, np.concatenate([np.stack([a, b, c], 1), np.stack([c, b, d], 1)])
    )


def placed(at, scale=1.0, turn=0.0):
    """world_from_mesh: scaled, turned by degrees about +y, moved."""
    c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    m = np.eye(4)
    m[:3, :3] = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) * np.broadcast_to(scale, 3)
    m[:3, 3] = at
    return m


# ---- scenes


def box_room():
    """The inside of [-1, 1]^3 with its front open, and a lamp of 0.5 m x 0.5 m under the ceiling."""
    s = Scene(camera=dict(origin=[0, 0, 3.9], target=[0, 0, 0], yfov=39.0), env=False)
    s.meshes = dict(
        floor=quad((-1, -1, 1), (1, -1, 1), (1, -1, -1), (-1, -1, -1)),
        ceiling=quad((-1, 1, -1), (1, 1, -1), (1, 1, 1), (-1, 1, 1)),
        back=quad((-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1)),
        left=quad((-1, -1, 1), (-1, -1, -1), (-1, 1, -1), (-1, 1, 1)),
        right=quad((1, -1, -1), (1, -1, 1), (1, 1, 1), (1, 1, -1)),
        lamp=quad((-0.25, 0.9995, -0.25), (0.25, 0.9995, -0.25), (0.25, 0.9995, 0.25), (-0.25, 0.9995, 0.25)),
    )
    s.materials = dict(
        white=dict(kind="diffuse", color=[0.73, 0.73, 0.73]),
        red=dict(kind="diffuse", color=[0.63, 0.065, 0.05]),
        green=dict(kind="diffuse", color=[0.14, 0.45, 0.091]),
        light=dict(kind="light", radiance=[18.0, 14.0, 8.0]),
    )
    walls = dict(floor="white", ceiling="white", back="white", left="red", right="green", lamp="light")
    for mesh, material in walls.items():
        s.add(mesh, material)
    return s


def cornell():
    s = box_room()
    s.meshes["box"] = cube()
    s.add("box", "white", placed((-0.33, -0.4, -0.3), (0.3, 0.6, 0.3), 18))
    s.add("box", "white", placed((0.33, -0.7, 0.3), (0.3, 0.3, 0.3), -17))
    return s


def glass():
    s = box_room()
    s.meshes.update(ball=icosphere(5), box=cube())
    for name, roughness in (("clear", 0.0), ("satin", 0.3), ("frosted", 0.6)):
        s.materials[name] = dict(kind="glass", ior=1.5, roughness=roughness)
    s.add("ball", "clear", placed((-0.45, -0.62, 0.25), 0.37))
    s.add("ball", "frosted", placed((0.05, -0.65, -0.5), 0.34))
    s.add("box", "satin", placed((0.48, -0.59, 0.3), (0.22, 0.4, 0.22), -25))
    return s


METALS = [[1.0, 0.77, 0.34], [0.95, 0.64, 0.54], [0.91, 0.92, 0.92], [0.97, 0.96, 0.91], [0.56, 0.57, 0.58]]


def spheres():
    s = Scene(camera=dict(origin=[0, 4.6, 6.8], target=[0, 0.3, 0.1], yfov=42.0), env=True)
    s.meshes = dict(ground=quad((-12, 0, 12), (12, 0, 12), (12, 0, -12), (-12, 0, -12)), ball=icosphere(5))
    s.materials["ground"] = dict(kind="diffuse", color=[0.5, 0.5, 0.5])
    s.add("ground", "ground")
    for row, kind in enumerate(["diffuse", "plastic", "metal", "glass"]):
        for column in range(5):
            color = [0.2 + 0.15 * column, 0.65 - 0.12 * column, 0.25 + 0.1 * (3 * column % 5)]
            roughness = [0.1, 0.2, 0.35, 0.55, 0.8][column]
            material = dict(kind=kind, color=[round(c, 3) for c in color], roughness=roughness)
            if kind == "metal":
                material["color"] = METALS[column]
            if kind == "glass":
                material = dict(kind=kind, ior=1.5, roughness=[0.0, 0.15, 0.3, 0.5, 0.8][column])
            s.materials[f"{kind}{column}"] = material
            s.add("ball", f"{kind}{column}", placed(((column - 2) * 1.1, 0.46, (row - 1.5) * 1.15), 0.45))
    return s


def million():
    """Every triangle is its own: nothing is instanced."""
    s = Scene(camera=dict(origin=[0, 2.6, 7.5], target=[0, 0.5, 0], yfov=42.0), env=True)
    s.meshes["land"] = landscape(700, 9.0, seed=4)
    s.materials = dict(
        earth=dict(kind="diffuse", color=[0.42, 0.36, 0.26]),
        moss=dict(kind="diffuse", color=[0.20, 0.38, 0.12]),
        glaze=dict(kind="plastic", color=[0.62, 0.16, 0.11], roughness=0.25),
        brass=dict(kind="metal", color=[0.89, 0.75, 0.42], roughness=0.3),
    )
    s.add("land", "earth")
    stones = [("moss", -1.8, -0.3, 0.8), ("glaze", -0.35, 1.0, 0.6), ("brass", 1.35, 0.2, 0.75)]
    for number, (material, x, z, size) in enumerate(stones):
        s.meshes[f"stone{number}"] = boulder(6, 0.16, seed=11 + number)
        s.add(f"stone{number}", material, placed((x, 0.75 * size, z), size, 40 * number))
    return s


def interior():
    """A room of 5 m x 2.6 m x 4 m; the window is a hole in its right wall, towards the sun."""
    s = Scene(camera=dict(origin=[2.2, 1.5, 3.9], target=[-0.5, 0.9, 0.3], yfov=55.0), env=True)
    walls = [
        quad((-2.5, 2.6, 0), (2.5, 2.6, 0), (2.5, 2.6, 4), (-2.5, 2.6, 4)),
        quad((-2.5, 0, 0), (2.5, 0, 0), (2.5, 2.6, 0), (-2.5, 2.6, 0)),
        quad((2.5, 0, 4), (-2.5, 0, 4), (-2.5, 2.6, 4), (2.5, 2.6, 4)),
        quad((-2.5, 0, 4), (-2.5, 0, 0), (-2.5, 2.6, 0), (-2.5, 2.6, 4)),
    ]
    # The right wall, around a window of 2.6 m x 1.7 m.
    for z0, z1, y0, y1 in ((0, 0.6, 0, 2.6), (3.2, 4, 0, 2.6), (0.6, 3.2, 0, 0.7), (0.6, 3.2, 2.4, 2.6)):
        walls.append(quad((2.5, y0, z0), (2.5, y0, z1), (2.5, y1, z1), (2.5, y1, z0)))
    floor = quad((-2.5, 0, 4), (2.5, 0, 4), (2.5, 0, 0), (-2.5, 0, 0))
    s.meshes = dict(walls=joined(walls), floor=floor, box=cube(), ball=icosphere(5), stone=boulder(5, 0.16, seed=3))
    s.materials = dict(
        plaster=dict(kind="diffuse", color=[0.78, 0.75, 0.70]),
        boards=dict(kind="plastic", color=[0.36, 0.20, 0.10], roughness=0.3),
        cloth=dict(kind="diffuse", color=[0.12, 0.22, 0.45]),
        brass=dict(kind="metal", color=[0.89, 0.75, 0.42], roughness=0.25),
        clear=dict(kind="glass", ior=1.5, roughness=0.0),
    )
    s.add("walls", "plaster")
    s.add("floor", "boards")
    s.add("box", "cloth", placed((-1.3, 0.26, 0.75), (1.0, 0.25, 0.45)))
    s.add("box", "cloth", placed((-1.3, 0.77, 0.35), (1.0, 0.25, 0.12)))
    s.add("box", "boards", placed((0.35, 0.36, 1.3), (0.5, 0.35, 0.35), 20))
    s.add("ball", "brass", placed((0.2, 0.92, 1.3), 0.2))
    s.add("ball", "clear", placed((0.62, 0.87, 1.2), 0.15))
    s.add("stone", "plaster", placed((-0.6, 0.32, 2.2), 0.3))
    return s


def lamps():
    """Lamps are icosahedra, 1920 glowing triangles in all, of 1 to 6 cm and powers that differ 200 times."""
    s = Scene(camera=dict(origin=[0, 2.4, 6.2], target=[0, 0.4, 0], yfov=42.0), env=False)
    s.meshes = dict(
        ground=quad((-6, 0, 6), (6, 0, 6), (6, 0, -6), (-6, 0, -6)), lamp=icosphere(0), stone=boulder(5, 0.16, seed=5)
    )
    s.materials = dict(
        ground=dict(kind="plastic", color=[0.45, 0.45, 0.45], roughness=0.4),
        chalk=dict(kind="diffuse", color=[0.7, 0.68, 0.64]),
        steel=dict(kind="metal", color=[0.56, 0.57, 0.58], roughness=0.3),
    )
    s.add("ground", "ground")
    for number, (x, z, size) in enumerate([(-1.6, 0.2, 0.6), (-0.2, 1.3, 0.4), (0.4, -0.9, 0.8), (1.8, 0.6, 0.5)]):
        s.add("stone", ("chalk", "steel")[number % 2], placed((x, 0.8 * size, z), size, 50 * number))
    rng = np.random.default_rng(7)
    for number in range(96):
        x, z, height = rng.uniform(-4, 4), rng.uniform(-4, 3), rng.uniform(0.1, 2.0)
        color, power = rng.uniform(0.3, 1.0, 3), 20 * 200 ** rng.uniform(-0.5, 0.5)
        s.materials[f"light{number}"] = dict(kind="light", radiance=[round(v, 3) for v in color * power])
        s.add("lamp", f"light{number}", placed((x, height, z), rng.uniform(0.01, 0.06)))
    return s


def herd():
    """400 instances of six meshes, 2.9 million triangles if each were its own."""
    s = Scene(camera=dict(origin=[0, 3, 9], target=[0, 0.5, 0], yfov=42.0), env=True)
    s.meshes = dict(
        ground=quad((-30, 0, 30), (30, 0, 30), (30, 0, -30), (-30, 0, -30)),
        stone=boulder(4, 0.2, seed=2),
        ring=torus(0.6, 0.12),
    )
    s.materials = dict(
        ground=dict(kind="diffuse", color=[0.4, 0.4, 0.35]),
        clay=dict(kind="plastic", color=[0.5, 0.2, 0.1], roughness=0.3),
        moss=dict(kind="diffuse", color=[0.2, 0.5, 0.2]),
        brass=dict(kind="metal", color=[0.9, 0.8, 0.5], roughness=0.3),
    )
    s.add("ground", "ground")
    rng = np.random.default_rng(3)
    for number in range(400):
        x, z, size = rng.uniform(-12, 12), rng.uniform(-20, 5), rng.uniform(0.15, 0.5)
        material = ("clay", "moss", "brass")[number % 3]
        s.add(("stone", "ring")[number % 2], material, placed((x, 0.8 * size, z), size, rng.uniform(0, 360)))
    return s


def rings():
    """Short paths: three rings of polished gold under a lamp, nothing around them."""
    s = Scene(camera=dict(origin=[0, 2.2, 3.2], target=[0, 0.1, 0], yfov=40.0), env=False)
    s.meshes = dict(
        ground=quad((-6, 0, 6), (6, 0, 6), (6, 0, -6), (-6, 0, -6)),
        ring=torus(0.6, 0.12),
        lamp=quad((-0.2, 3, -0.2), (0.2, 3, -0.2), (0.2, 3, 0.2), (-0.2, 3, 0.2)),
    )
    s.materials = dict(
        ground=dict(kind="diffuse", color=[0.6, 0.6, 0.6]),
        gold=dict(kind="metal", color=[1, 0.77, 0.34], roughness=0.15),
        light=dict(kind="light", radiance=[300.0, 280.0, 250.0]),
    )
    s.add("ground", "ground")
    s.add("lamp", "light", placed((1.2, 0, -0.8)))
    for x, z, size in ((-0.9, -0.4, 0.6), (0.2, 0.5, 0.8), (1.1, -0.5, 0.5)):
        s.add("ring", "gold", placed((x, 0.12, z), size))
    return s


SCENES = dict(
    cornell=cornell,
    spheres=spheres,
    million=million,
    glass=glass,
    interior=interior,
    lamps=lamps,
    herd=herd,
    rings=rings,
)


# ---- the sky


def sky(width=512, height=256):
    """Radiance, height x width x 3: a blue gradient over dark ground, and a soft sun of 3 degrees' radius."""
    v, u = np.meshgrid((np.arange(height) + 0.5) / height, (np.arange(width) + 0.5) / width, indexing="ij")
    theta, phi = math.pi * v, 2 * math.pi * (u - 0.5)
    d = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], -1)
    blue = np.sqrt(np.clip(d[..., 1:2], 0, 1))
    image = (1 - blue) * [0.9, 0.95, 1.0] + blue * [0.15, 0.35, 0.9]
    image = np.where(d[..., 1:2] < 0, [0.12, 0.10, 0.08], image)
    sun = np.array([0.55, 0.62, 0.56])
    away = np.degrees(np.arccos(np.clip(d @ sun / np.linalg.norm(sun), -1, 1)))[..., None]
    return image + np.array([160.0, 140.0, 110.0]) * np.clip(3.0 - away, 0, 1)


def write_hdr(path, image):
    """Radiance RGBE, run-length form with literal runs only (Ward 1991, "Real Pixels")."""
    height, width, _ = image.shape
    _, exponent = np.frexp(image.max(-1))
    mantissa = np.clip(image / np.exp2(exponent)[..., None] * 256, 0, 255).astype(np.uint8)
    rgbe = np.concatenate([mantissa, (exponent + 128).astype(np.uint8)[..., None]], -1)
    with open(path, "wb") as out:
        out.write(f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode())
        for row in rgbe:
            out.write(struct.pack(">BBH", 2, 2, width))
            for channel in row.T:
                for start in range(0, width, 128):
                    run = channel[start : start + 128].tobytes()
                    out.write(bytes([len(run)]) + run)


# ---- files


def camera_node(camera):
    """world_from_camera: glTF's cameras look down their own -z, +y up."""
    origin, target = np.array(camera["origin"], float), np.array(camera["target"], float)
    z = (origin - target) / np.linalg.norm(origin - target)
    x = np.cross([0.0, 1.0, 0.0], z)
    x /= np.linalg.norm(x)
    m = np.eye(4)
    m[:3, :4] = np.stack([x, np.cross(z, x), z, origin], 1)
    return m


def gltf_camera(camera):
    return dict(
        type="perspective", perspective=dict(yfov=math.radians(camera["yfov"]), aspectRatio=1.0, znear=0.01, zfar=1e4)
    )


def column_major(m):
    return np.asarray(m, float).T.ravel().tolist()


def gltf_material(name, m):
    kind = m["kind"]
    color = [0, 0, 0] if kind == "light" else m.get("color", [1, 1, 1])
    out = dict(
        name=name,
        doubleSided=kind not in ("glass", "light"),
        pbrMetallicRoughness=dict(
            baseColorFactor=[*color, 1.0],
            metallicFactor=float(kind == "metal"),
            roughnessFactor=float(1.0 if kind == "diffuse" else m.get("roughness", 1.0)),
        ),
    )
    extensions = {}
    if kind in ("diffuse", "light"):
        extensions["KHR_materials_specular"] = dict(specularFactor=0.0)
    if kind == "glass":
        extensions["KHR_materials_transmission"] = dict(transmissionFactor=1.0)
        extensions["KHR_materials_ior"] = dict(ior=m["ior"])
        extensions["KHR_materials_volume"] = dict(thicknessFactor=1.0)
    if kind == "light":
        strength = max(m["radiance"])
        out["emissiveFactor"] = [x / strength for x in m["radiance"]]
        extensions["KHR_materials_emissive_strength"] = dict(emissiveStrength=strength)
    if extensions:
        out["extensions"] = extensions
    return out


class Glb:
    """A .glb whose buffer goes to the file as it is added to, so that it may be larger than memory."""

    def __init__(self, path):
        self.path, self.body, self.length = Path(path), open(f"{path}.body", "w+b"), 0
        self.views, self.accessors = [], []

    def array(self, values, kind, bounds=False):
        """Adds n x width values (float32 or unsigned) and returns their accessor."""
        component = {"float32": 5126, "uint32": 5125}[str(values.dtype)]
        data = np.ascontiguousarray(values)
        self.views.append(dict(buffer=0, byteOffset=self.length, byteLength=data.nbytes))
        accessor = dict(bufferView=len(self.views) - 1, componentType=component, count=len(values), type=kind)
        if bounds:
            accessor.update(min=values.min(0).tolist(), max=values.max(0).tolist())
        self.accessors.append(accessor)
        data.tofile(self.body)
        self.length += data.nbytes
        return len(self.accessors) - 1

    def file(self, data):
        """Adds the bytes of a file, such as a picture, and returns their view."""
        self.views.append(dict(buffer=0, byteOffset=self.length, byteLength=len(data)))
        padded = data + bytes(-len(data) % 4)
        self.body.write(padded)
        self.length += len(padded)
        return len(self.views) - 1

    def close(self, document):
        extensions = sorted(
            {e for part in ("materials", "nodes") for x in document.get(part, []) for e in x.get("extensions", {})}
            | set(document.get("extensions", {}))
        )
        document = dict(
            asset=dict(version="2.0", generator="snell benches/scenes.py"),
            scene=0,
            accessors=self.accessors,
            bufferViews=self.views,
            buffers=[dict(byteLength=self.length)],
            **document,
        )
        if extensions:
            document["extensionsUsed"] = extensions
        text = json.dumps({k: v for k, v in document.items() if v != []}).encode()
        text += b" " * (-len(text) % 4)
        with open(self.path, "wb") as out:
            out.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + self.length))
            out.write(struct.pack("<I4s", len(text), b"JSON") + text)
            out.write(struct.pack("<I4s", self.length, b"BIN\0"))
            self.body.seek(0)
            while part := self.body.read(1 << 24):
                out.write(part)
        self.body.close()
        Path(self.body.name).unlink()


def write_glb(path, s):
    glb = Glb(path)
    arrays = {
        name: (
            glb.array(m.positions.astype("float32"), "VEC3", bounds=True),
            glb.array(m.normals.astype("float32"), "VEC3"),
            glb.array(m.triangles.astype("uint32").ravel(), "SCALAR"),
        )
        for name, m in s.meshes.items()
    }
    materials, meshes, index, nodes = list(s.materials), [], {}, []
    for mesh, material, m in s.nodes:
        if (mesh, material) not in index:
            index[mesh, material] = len(meshes)
            position, normal, triangles = arrays[mesh]
            primitive = dict(attributes=dict(POSITION=position, NORMAL=normal), indices=triangles)
            meshes.append(dict(name=f"{mesh} {material}", primitives=[dict(primitive, material=materials.index(material))]))
        nodes.append(dict(mesh=index[mesh, material], matrix=column_major(m)))
    nodes.append(dict(name="camera", camera=0, matrix=column_major(camera_node(s.camera))))
    glb.close(
        dict(
            scenes=[dict(nodes=list(range(len(nodes))))],
            nodes=nodes,
            meshes=meshes,
            cameras=[gltf_camera(s.camera)],
            materials=[gltf_material(name, m) for name, m in s.materials.items()],
        )
    )


def write_ply(path, mesh, uv=None):
    columns = [mesh.positions, mesh.normals] + ([] if uv is None else [uv])
    names = ["x", "y", "z", "nx", "ny", "nz"] + ([] if uv is None else ["u", "v"])
    faces = np.empty(len(mesh.triangles), [("n", "u1"), ("i", "<i4", 3)])
    faces["n"], faces["i"] = 3, mesh.triangles
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(mesh.positions)}"]
    header += [f"property float {n}" for n in names]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    with open(path, "wb") as out:
        out.write("\n".join(header).encode() + b"\n")
        np.concatenate(columns, 1).astype("<f4").tofile(out)
        faces.tofile(out)


def write(folder, name):
    """Writes a scene's files into the folder and returns how many triangles it has."""
    folder, s = Path(folder), SCENES[name]()
    write_glb(folder / f"{name}.glb", s)
    files = {mesh: f"{name}_{mesh}.ply" for mesh in s.meshes}
    for mesh, file in files.items():
        write_ply(folder / file, s.meshes[mesh])
    nodes = [dict(mesh=files[mesh], material=material, matrix=m.tolist()) for mesh, material, m in s.nodes]
    plain = dict(triangles=s.triangles(), materials=s.materials, camera=s.camera, env=s.env, nodes=nodes)
    (folder / f"{name}.json").write_text(json.dumps(plain))
    return plain["triangles"]


def main():
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    write_hdr(folder / "env.hdr", sky())
    for name in sys.argv[2:] or SCENES:
        print(f"{name}: {write(folder, name)} triangles")


if __name__ == "__main__":
    main()
