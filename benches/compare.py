"""Snell beside Mitsuba 3 and Blender's Cycles: the same scenes, in turns, in one run. See benches/README.md.

    python benches/compare.py throughput [--icd NAME=FILE.json] [--scenes ...] [--asset FILE.gltf] [--rounds N] [--json OUT] ...
    python benches/compare.py latency --asset FILE.gltf [--icd NAME=FILE.json] [--rounds N] [--json OUT] ...

Prints a table in Markdown; --json keeps every figure of every round.
"""

import argparse
import hashlib
import json
import os
import platform
import resource
import statistics
import struct
import subprocess
import sys
import time
import zlib
from datetime import date
from pathlib import Path

import numpy as np

import asset
import scenes

HERE = Path(__file__).resolve().parent
# Surface interactions after the first: Mitsuba's max_depth 8, Cycles' 6 bounces.
SNELL_DEPTH = 7
# Squared errors are taken relative to the squared reference plus this, lest black pixels rule.
DARK = 1e-2
# Share of the pixels, the worst, that the trimmed error leaves out.
TRIM = 1e-3
# Side of the blocks of pixels that the references' agreement is judged by.
BLOCK = 16
# Seeds of the references; those of the rounds are far below.
REFERENCE_SEED = 10_000
# Paths of one picture of a reference, which is the mean of as many as it needs: bounds Mitsuba's memory.
REFERENCE_PATHS = 1 << 23


class Missing(Exception):
    """A renderer that is not there, in a sentence."""


# ---- the renderers


class Snell:
    """A command for each picture. Its `render` time of --report counts: no load, no hierarchy, no upload, no making of
    pipelines, but a software driver's fetching of compiled code from its cache, and the film's way back."""

    convention = "snell"

    def __init__(self, name, program, options=(), icd=None, cache=None):
        self.name, self.program, self.options = name, program, list(options)
        if not Path(program).is_file():
            raise Missing(f"{name} is left out: there is no program {program} (cargo build --release)")
        self.environment = dict(os.environ, RUST_LOG="off")
        if cache:
            self.environment["MESA_SHADER_CACHE_DIR"] = str(cache)
        if icd:
            if not Path(icd).is_file():
                raise Missing(f"{name} is left out: there is no driver's file {icd}")
            self.environment.update(VK_ICD_FILENAMES=str(icd), VK_DRIVER_FILES=str(icd))
        self.version = None

    def command(self, folder, gltf, env, size, spp, out):
        command = [self.program, "render", str(folder / gltf), "-o", str(out), "--size", f"{size}x{size}"]
        command += ["--spp", str(spp), "--max-depth", str(SNELL_DEPTH), "--tonemap", "linear", "--quiet", *self.options]
        if env is True:
            command += ["--env", str(folder / "env.hdr")]
        elif env:
            command += ["--env", ",".join(map(str, env))]
        return command

    def picture(self, scene, size, spp, out):
        """What latency times."""
        plain = json.loads(scene.read_text())
        command = self.command(scene.parent, plain["gltf"], plain["env"], size, spp, out)
        return run(command, self.environment)

    def render(self, scene, size, spp, seed, out):
        plain, exr, record = json.loads(scene.read_text()), out.with_suffix(".exr"), out.with_suffix(".report.json")
        command = self.command(scene.parent, plain.get("gltf", f"{scene.stem}.glb"), plain["env"], size, spp, exr)
        used = run([*command, "--seed", str(seed), "--report", str(record)], self.environment)["processor_seconds"]
        report = json.loads(record.read_text())
        adapter = report["adapter"]
        self.version = f"{report['snell']}, {adapter.get('driver_info') or 'float64 CPU renderer'}"
        np.save(out, read_exr(exr))
        exr.unlink()
        # Only the whole command's processor time is known.
        return dict(seconds=report["times_ms"]["render"] / 1e3, times_ms=report["times_ms"], command_processor_seconds=used)


class Peer:
    """Another renderer: one process that keeps the scene while its rounds last, and a cold one for latency."""

    def __init__(self, name, pixel_filter, script, *arguments):
        self.name, self.filter, self.start = name, pixel_filter, [sys.executable, str(HERE / script)]
        self.convention = script.split("_")[1].removesuffix(".py") + ("" if pixel_filter == "box" else f"-{pixel_filter}")
        self.arguments, self.environment = list(arguments), dict(os.environ)
        self.process = None
        self.version = self.ask(version=True)["version"]

    def ask(self, **request):
        if self.process is None:
            self.process = subprocess.Popen(
                [*self.start, "worker", *self.arguments], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                stderr=subprocess.PIPE if "version" in request else None, text=True,
            )  # fmt: skip
        try:
            self.process.stdin.write(json.dumps(request) + "\n")
            self.process.stdin.flush()
        except BrokenPipeError:
            pass
        for line in self.process.stdout:
            if line.startswith("ANSWER "):
                return json.loads(line.removeprefix("ANSWER "))
        said = self.process.stderr.read().strip().splitlines() if self.process.stderr else []
        why = said[-1] if said else f"its process ended with {self.process.wait()}"
        self.process = None
        raise Missing(f"{self.name} is left out: {why}")

    def close(self):
        if self.process is not None:
            self.process.stdin.close()
            self.process.wait()
            self.process = None

    def render(self, scene, size, spp, seed, out):
        return self.ask(scene=str(scene), size=size, spp=spp, seed=seed, filter=self.filter, out=str(out))

    def picture(self, scene, size, spp, out):
        return run([*self.start, "picture", *self.arguments, str(scene), str(size), str(spp), str(out)], self.environment)


def run(command, environment):
    """Wall and processor seconds of a command that must succeed."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    seconds, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(command)}\nended with {done.returncode}:\n{done.stdout}{done.stderr}")
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return dict(seconds=seconds, processor_seconds=used)


def renderers(arguments):
    """All that are wanted and there; what is missing is said, and left out."""

    def named(text):
        name, _, value = text.rpartition("=")
        return name, value

    makers = []
    for label, program in map(named, arguments.snell):
        title = f"Snell {label}".strip()
        for icd_name, icd in [("", None), *map(named, arguments.icd)]:
            options = ["--adapter", arguments.adapter] if arguments.adapter else []
            name, cache = f"{title} {icd_name}".strip(), arguments.cache / "mesa" / (icd_name or "default")
            makers.append((name, lambda n=name, p=program, o=options, i=icd, c=cache: Snell(n, p, o, i, c)))
        name = f"{title} --cpu"
        makers.append((name, lambda n=name, p=program: Snell(n, p, ["--cpu"])))
    variants = ["llvm_ad_rgb", *arguments.mitsuba]
    for variant in dict.fromkeys(variants):
        name = f"Mitsuba {variant}"
        makers.append((name, lambda n=name, v=variant: Peer(n, arguments.filter, "peer_mitsuba.py", v)))
    makers.append(("Cycles", lambda: Peer("Cycles", arguments.filter, "peer_cycles.py")))

    found = []
    for name, make in makers:
        if arguments.only and not any(part.lower() in name.lower() for part in arguments.only):
            continue
        try:
            found.append(make())
        except Missing as missing:
            say(str(missing))
    if not found:
        raise SystemExit("no renderer is left")
    return found


# ---- pictures and errors


def read_exr(path):
    import OpenEXR

    with OpenEXR.File(str(path)) as file:
        channels = file.channels()
        for name in ("RGB", "RGBA"):
            if name in channels:
                return np.array(channels[name].pixels, np.float32)[..., :3]
        return np.stack([channels[c].pixels for c in "RGB"], -1).astype(np.float32)


def write_png(path, image):
    """Clipped at 1, sRGB."""
    linear = np.clip(image, 0, 1)
    srgb = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    rows = (srgb * 255 + 0.5).astype(np.uint8)
    height, width, _ = rows.shape

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    raw = b"".join(b"\0" + row.tobytes() for row in rows)
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    body = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b"")
    Path(path).write_bytes(b"\x89PNG\r\n\x1a\n" + body)


def errors(image, reference):
    """relMSE over all pixels, and with the worst left out."""
    reference = reference.astype(float)
    pixel = ((image - reference) ** 2 / (reference**2 + DARK)).mean(-1).ravel()
    kept = np.sort(pixel)[: int(pixel.size * (1 - TRIM))]
    return pixel.mean(), kept.mean()


def blocks(image):
    """Means over blocks and channels, which noise and pixel filters hardly touch."""
    n = image.shape[0] // BLOCK * BLOCK
    return image[:n, :n].mean(-1).reshape(n // BLOCK, BLOCK, n // BLOCK, BLOCK).mean((1, 3))


def reference(renderer, scene, size, spp, cache):
    """The mean of pictures with seeds of their own; kept on disk."""
    gltf = json.loads(scene.read_text()).get("gltf", f"{scene.stem}.glb")
    digest = hashlib.sha256(scene.read_bytes() + (scene.parent / gltf).read_bytes()).hexdigest()[:12]
    path = cache / "reference" / f"{scene.stem}.{renderer.convention}.{size}.{spp}.{digest}.npy"
    if path.is_file():
        return np.load(path)
    say(f"{scene.stem}: {spp} samples of {renderer.name} for the reference")
    each = max(1, min(spp, REFERENCE_PATHS // (size * size)))
    total = np.zeros((size, size, 3))
    path.parent.mkdir(parents=True, exist_ok=True)
    done = 0
    while done < spp:
        part = min(each, spp - done)
        out = path.with_suffix(".part.npy")
        renderer.render(scene, size, part, REFERENCE_SEED + done, out)
        total += part * np.load(out).astype(float)
        out.unlink()
        done += part
    np.save(path, (total / spp).astype(np.float32))
    write_png(path.with_suffix(".png"), total / spp)
    return np.load(path)


# ---- the two measurements


def throughput(arguments):
    found = renderers(arguments)
    folder = arguments.cache / "scenes"
    folder.mkdir(parents=True, exist_ok=True)
    scenes.write_hdr(folder / "env.hdr", scenes.sky())
    result = dict(machine(), size=arguments.size, spp=arguments.spp, reference_spp=arguments.reference_spp)
    result |= dict(filter=arguments.filter, scenes={})
    written = {}
    for name in arguments.scenes:
        scenes.write(folder, name)
        written[name] = folder / f"{name}.json"
    if arguments.asset:
        scene = asset.prepare(arguments.asset, folder, env=True)
        written[scene.stem] = scene
    for name, scene in written.items():
        triangles = json.loads(scene.read_text())["triangles"]
        references, rounds = {}, {r.name: [] for r in found}
        for r in found:
            if r.convention not in references:
                references[r.convention] = reference(r, scene, arguments.size, arguments.reference_spp, arguments.cache)
        for number in range(-1, arguments.rounds):  # round -1 fills caches and does not count
            for r in found:
                out = arguments.cache / "picture.npy"
                seed = 1 + max(number, 0)
                figures = r.render(scene, arguments.size, arguments.spp, seed, out)
                if number < 0:
                    continue
                all_pixels, trimmed = errors(np.load(out), references[r.convention])
                rounds[r.name].append(dict(figures, seed=seed, relmse=all_pixels, relmse_trimmed=trimmed))
                say(f"{name}, round {number + 1}: {r.name} {figures['seconds']:.2f} s, relMSE {all_pixels:.2e}")
        result["scenes"][name] = dict(triangles=triangles, rounds=rounds, agreement=agreement(references))
    result["renderers"] = {r.name: r.version for r in found}
    for r in found:
        getattr(r, "close", lambda: None)()
    return result, throughput_table(result)


def agreement(references):
    """How far the renderers' references are apart: ratio of means to the first's, and the 95 % quantile and
    maximum of the blocks' relative differences."""
    out, first = {}, next(iter(references))
    a = references[first].astype(float)
    for name, image in references.items():
        difference = np.abs(blocks(image.astype(float)) - blocks(a)) / (blocks(a) + DARK)
        out[name] = dict(
            mean=image.mean((0, 1)).tolist(),
            mean_ratio=float(image.mean() / a.mean()),
            blocks_95=float(np.quantile(difference, 0.95)),
            blocks_max=float(difference.max()),
        )
    return out


def throughput_table(result):
    paths = result["size"] ** 2 * result["spp"]
    lines = [
        *heading(result),
        f"{result['size']} x {result['size']}, {result['spp']} samples, references of {result['reference_spp']} samples"
        " by each renderer itself; medians of the rounds; trimmed: without the worst 0.1 % of pixels;"
        f" ratios are of 1/(relMSE s). The others' pixel filter: {result['filter']}.",
        "",
    ]
    for name, scene in result["scenes"].items():
        rows = {}
        for renderer, rounds in scene["rounds"].items():
            rows[renderer] = dict(
                speed=statistics.median(paths / r["seconds"] / 1e6 for r in rounds),
                relmse=statistics.median(r["relmse"] for r in rounds),
                trimmed=statistics.median(r["relmse_trimmed"] for r in rounds),
                score=statistics.median(1 / (r["relmse"] * r["seconds"]) for r in rounds),
                score_trimmed=statistics.median(1 / (r["relmse_trimmed"] * r["seconds"]) for r in rounds),
            )
        scene["medians"] = rows
        peers = [p for p in ("Cycles", "Mitsuba llvm_ad_rgb", "Mitsuba cuda_ad_rgb") if p in rows]
        lines += [f"**{name}**, {scene['triangles']} triangles", ""]
        titles = ["", "Mpaths/s", "relMSE", "trimmed", "1/(relMSE s)", "trimmed"]
        titles += [f"{kind} {p.removesuffix('_ad_rgb')}" for p in peers for kind in ("to", "trimmed, to")]
        lines += [f"| {' | '.join(titles)} |", f"|{' --- |' * len(titles)}"]
        for renderer, row in rows.items():
            cells = [renderer, f"{row['speed']:.3g}", f"{row['relmse']:.2e}", f"{row['trimmed']:.2e}"]
            cells += [f"{row['score']:.3g}", f"{row['score_trimmed']:.3g}"]
            for p in peers:
                cells += [f"{row[k] / rows[p][k]:.2f}" for k in ("score", "score_trimmed")]
            lines.append(f"| {' | '.join(cells)} |")
        said = [
            f"{k} {a['mean_ratio']:.3f} (blocks of {BLOCK} x {BLOCK}: 95 % within {a['blocks_95']:.1%})"
            for k, a in scene["agreement"].items()
        ]
        lines += ["", f"Means of the references, relative to the first: {'; '.join(said)}.", ""]
    return lines


def latency(arguments):
    if not arguments.asset:
        raise SystemExit("latency needs --asset FILE.gltf")
    arguments.mitsuba.append("scalar_rgb")
    found = renderers(arguments)
    for r in found:
        getattr(r, "close", lambda: None)()
    scene = asset.prepare(arguments.asset, arguments.cache / "asset")
    result = dict(machine(), size=arguments.size, spp=arguments.spp, asset=Path(arguments.asset).name)
    result["rounds"] = {r.name: [] for r in found}
    for number in range(-1, arguments.rounds):  # round -1 fills the caches of drivers and of the disk
        for r in found:
            out = arguments.cache / f"latency_{r.name.replace(' ', '_')}.png"
            out.unlink(missing_ok=True)
            figures = r.picture(scene, arguments.size, arguments.spp, out)
            if not out.is_file():
                raise SystemExit(f"{r.name} wrote no {out}")
            if number >= 0:
                result["rounds"][r.name].append(figures)
                say(f"round {number + 1}: {r.name} {figures['seconds']:.2f} s")
    result["renderers"] = {r.name: r.version for r in found if r.version}
    medians = {
        name: {key: statistics.median(f[key] for f in rounds) for key in ("seconds", "processor_seconds")}
        for name, rounds in result["rounds"].items()
    }
    result["medians"] = medians
    others = [m["seconds"] for name, m in medians.items() if not name.startswith("Snell")]
    lines = [
        *heading(result),
        f"Cold process to PNG on disk, {result['asset']}, {result['size']} x {result['size']}, {result['spp']} samples,"
        f" warm caches, medians of {arguments.rounds} rounds.",
        "",
        "| | seconds | processor seconds | to the fastest other renderer |",
        "| --- | --- | --- | --- |",
    ]
    for name, m in medians.items():
        ratio = f"{m['seconds'] / min(others):.2f}" if others else "-"
        lines.append(f"| {name} | {m['seconds']:.2f} | {m['processor_seconds']:.2f} | {ratio} |")
    return result, lines


# ---- words


def machine():
    model = platform.processor()
    for line in Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []:
        if line.startswith("model name"):
            model = line.split(":", 1)[1].strip()
    return dict(
        date=date.today().isoformat(), processor=model, cores=len(os.sched_getaffinity(0)), load=os.getloadavg()[0]
    )


def heading(result):
    versions = "; ".join(f"{name}: {version}" for name, version in result["renderers"].items())
    return [
        f"{result['date']}, {result['processor']}, {result['cores']} cores (load {result['load']:.1f} at the start). {versions}.",
        "",
    ]


def say(text):
    print(text, file=sys.stderr, flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("measure", choices=["throughput", "latency"])
    parser.add_argument(
        "--snell", action="append", metavar="[NAME=]PROGRAM", help="default target/release/snell; more than one to compare"
    )
    parser.add_argument("--icd", action="append", default=[], metavar="NAME=FILE.json", help="another Vulkan driver")
    parser.add_argument("--adapter", help="Snell's --adapter")
    parser.add_argument(
        "--mitsuba", action="append", default=[], metavar="VARIANT", help="besides llvm_ad_rgb, such as cuda_ad_rgb"
    )
    parser.add_argument("--only", action="append", metavar="PART", help="only renderers whose name holds this")
    parser.add_argument("--scenes", nargs="+", default=list(scenes.SCENES), choices=list(scenes.SCENES))
    parser.add_argument("--asset", metavar="FILE.gltf", help="a textured asset: latency's, or one more scene, under the sky")
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--spp", type=int, help="default 64, latency 16")
    parser.add_argument("--reference-spp", type=int, default=2048)
    parser.add_argument(
        "--filter", choices=["box", "wide"], default="box", help="pixels of the others: boxes, or as wide as Snell's"
    )
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--cache", type=Path, default=HERE.parent / "target" / "compare", help="scenes, references, caches")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--markdown", type=Path)
    arguments = parser.parse_args()
    arguments.snell = arguments.snell or [str(HERE.parent / "target" / "release" / "snell")]
    arguments.spp = arguments.spp or (64 if arguments.measure == "throughput" else 16)
    arguments.cache = arguments.cache.resolve()
    arguments.cache.mkdir(parents=True, exist_ok=True)
    measure = throughput if arguments.measure == "throughput" else latency
    result, lines = measure(arguments)
    text = "\n".join(lines) + "\n"
    print(text)
    if arguments.json:
        arguments.json.write_text(json.dumps(result, indent=1) + "\n")
    if arguments.markdown:
        arguments.markdown.write_text(text)


if __name__ == "__main__":
    main()
