#!/usr/bin/env python3
"""Compares pictures by Mobula with pictures of the same scenes by Mitsuba 3: light without noise must agree within noise.

    pip install mitsuba numpy
    cargo build --release
    python3 benches/reference/compare.py target/release/mobula MODEL.obj [--samples 256] [--record FILE --date YYYY-MM-DD]

Two scenes of a textured OBJ model, both with direct light only:
  environment  under an environment map that is made here: a sky with a gradient and a bright patch;
  openness     all white, under a sky that is white everywhere: ambient occlusion.

Both see facets (no vertex normals), the same pinhole camera, a box filter, and linear colours (EXR). The root mean square error between
the two is compared with the noise of either, which is estimated from two pictures by Mitsuba with different seeds.
"""

import argparse
import platform
import subprocess
import sys
import tempfile
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")

SIZE = (320, 240)


def sky(width=256, height=128):
    """An environment map: rows from straight up to straight down."""
    v, u = np.mgrid[0:height, 0:width]
    up = np.cos((v + 0.5) / height * np.pi)
    around = (u + 0.5) / width * 2 * np.pi
    color = np.stack([0.5 + 0.3 * up, 0.6 + 0.2 * up + 0.1 * np.sin(around), 0.7 + 0.3 * up], axis=-1)
    patch = (np.abs(v - height * 0.25) < height * 0.06) & (np.abs(u - width * 0.30) < width * 0.04)
    color[patch] = [30.0, 26.0, 20.0]
    return color.astype(np.float32)


def facets(model, folder):
    """The model without vertex normals, its files beside it, and the bounds of its vertices."""
    lines, corners = [], []
    for line in model.read_text(errors="replace").splitlines():
        words = line.split()
        if words[:1] == ["vn"]:
            continue
        if words[:1] == ["v"]:
            corners.append([float(word) for word in words[1:4]])
        if words[:1] == ["f"]:
            line = "f " + " ".join("/".join(corner.split("/")[:2]).rstrip("/") for corner in words[1:])
        lines.append(line)
    for beside in model.parent.iterdir():
        if beside.is_file() and beside.suffix != ".obj":
            (folder / beside.name).write_bytes(beside.read_bytes())
    path = folder / model.name
    path.write_text("\n".join(lines))
    corners = np.array(corners)
    return path, corners.min(axis=0), corners.max(axis=0)


def camera(low, high):
    """Eye, what is looked at, and the vertical field of view."""
    at, size = (low + high) / 2, np.linalg.norm(high - low)
    return at + size * np.array([0.9, 0.5, 1.1]), at, 35.0


def parts(path, folder):
    """A mesh and a material for each material of the model: Mitsuba has one of each a shape."""
    head, faces, name = [], {}, None
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ["usemtl"]:
            name = line.split(None, 1)[1]
        elif words[:1] == ["f"]:
            faces.setdefault(name, []).append(line)
        elif words[:1] in (["v"], ["vt"]):
            head.append(line)
    for number, (name, lines) in enumerate(faces.items()):
        part = folder / f"part{number}.obj"
        part.write_text("\n".join(head + lines))
        yield name, part


def materials(path):
    """What MTL files beside the model say: colour, and texture."""
    found = {}
    for mtl in path.parent.glob("*.mtl"):
        blender = "Blender" in mtl.read_text(errors="replace")
        for line in mtl.read_text(errors="replace").splitlines():
            words = line.split(None, 1)
            if len(words) < 2:
                continue
            if words[0] == "newmtl":
                current = found.setdefault(words[1].strip(), {"color": [0.7] * 3, "texture": None, "blender": blender})
            elif words[0] == "Kd":
                current["color"] = [float(x) for x in words[1].split()[:3]]
            elif words[0] == "map_Kd":
                current["texture"] = path.parent / words[1].strip()
    return found


def theirs(path, folder, view, environment, white, samples, seed):
    """A picture by Mitsuba."""
    eye, at, fov = view
    scene = {
        "type": "scene",
        "integrator": {"type": "direct", "emitter_samples": 1, "bsdf_samples": 1},
        "sensor": {
            "type": "perspective",
            "fov": fov,
            "fov_axis": "y",
            "to_world": mi.ScalarTransform4f().look_at(origin=list(eye), target=list(at), up=[0, 1, 0]),
            "film": {"type": "hdrfilm", "width": SIZE[0], "height": SIZE[1], "rfilter": {"type": "box"}},
            "sampler": {"type": "independent", "sample_count": samples, "seed": seed},
        },
        "sky": environment,
    }
    known = {} if white else materials(path)
    for number, (name, part) in enumerate(parts(path, folder)):
        material = known.get(name, {"color": [1.0] * 3 if white else [0.7] * 3, "texture": None})
        reflectance = {"type": "rgb", "value": material["color"]}
        if material["texture"] is not None:
            reflectance = {"type": "bitmap", "filename": str(material["texture"])}
        scene[f"part{number}"] = {
            "type": "obj",
            "filename": str(part),
            "face_normals": True,
            "bsdf": {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": reflectance}},
        }
    return np.array(mi.render(mi.load_dict(scene), seed=seed))[:, :, :3]


def ours(mobula, path, folder, view, options, samples):
    """A picture by Mobula."""
    eye, at, fov = view
    out = folder / "mobula.exr"
    point = lambda p: ",".join(repr(float(x)) for x in p)
    command = [mobula, "render", str(path), "-o", str(out), "--size", "x".join(map(str, SIZE)), "--up", "y"]
    command += ["--eye", point(eye), "--at", point(at), "--fov", str(fov), "--smooth", "0"]
    command += ["--samples", str(samples), "--filter", "box", *options]
    subprocess.run(command, check=True, capture_output=True)
    layers = mi.Bitmap(str(out))
    names = [field.name for field in layers.struct_()]
    return np.array(layers)[:, :, [names.index(channel) for channel in "RGB"]]


def rmse(a, b):
    return float(np.sqrt(np.mean((np.minimum(a, 4.0) - np.minimum(b, 4.0)) ** 2)))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("mobula")
    parser.add_argument("model", type=Path)
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--record", type=Path)
    parser.add_argument("--date", default="undated")
    arguments = parser.parse_args()
    rows, failed = [], False
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / "parts").mkdir()
        path, low, high = facets(arguments.model, folder)
        view = camera(low, high)
        mi.Bitmap(sky()).write(str(folder / "sky.exr"))
        # The middle of the picture is at negative z in Mobula, at positive z in Mitsuba.
        half_turn = mi.ScalarTransform4f().rotate([0, 1, 0], 180)
        mapped = {"type": "envmap", "filename": str(folder / "sky.exr"), "to_world": half_turn}
        even = {"type": "constant", "radiance": {"type": "rgb", "value": 1.0}}
        for name, environment, white, options in [
            ("environment", mapped, False, ["--background", str(folder / "sky.exr")]),
            ("openness", even, True, ["--renderer", "ao"]),
        ]:
            a, b = (theirs(path, folder / "parts", view, environment, white, arguments.samples, seed) for seed in (1, 2))
            c = ours(arguments.mobula, path, folder, view, options, arguments.samples)
            # Half of the square of what two pictures differ by is each one's own.
            noise, error = rmse(a, b) / 2**0.5, rmse((a + b) / 2, c)
            bias = float(np.mean(np.minimum(c, 4.0)) - np.mean(np.minimum((a + b) / 2, 4.0)))
            rows.append(f"| {name} | {arguments.samples} | {noise:.5f} | {error:.5f} | {bias:+.5f} |")
            failed |= error > 2 * noise
    text = "\n".join(
        [
            f"# Mobula beside Mitsuba {mi.__version__}, {arguments.date}",
            "",
            f"- Command: `python3 benches/reference/compare.py {' '.join(sys.argv[1:])}`",
            f"- Machine: {platform.processor() or platform.machine()}",
            "",
            "Linear colours, cut off at 4. The noise is that of one picture by Mitsuba; the error that of Mobula against the mean of two.",
            "",
            "| scene | samples a pixel | noise (RMSE) | error (RMSE) | difference of means |",
            "|---|---|---|---|---|",
            *rows,
            "",
        ]
    )
    print(text)
    if arguments.record:
        arguments.record.write_text(text)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
