"""Makes a GLB file of about 50 MB for the program `glb`: a wavy sheet of 500,000 triangles with normals and texture coordinates, whose
material has four PNG or JPEG images of 2048 x 2048. Needs `pip install numpy pillow`.

    python3 benches/reference/glb.py sheet.glb [png|jpeg]
"""

import io
import json
import struct
import sys

import numpy
from PIL import Image

SIDE, TEXELS = 501, 2048


def picture(seed, kind):
    """Smooth colours with some noise, which compress about as photographs do."""
    random = numpy.random.default_rng(seed)
    y, x = numpy.mgrid[0:TEXELS, 0:TEXELS] / TEXELS
    waves = [numpy.sin(20 * (x * a + y * b) + c) for a, b, c in random.uniform(-1, 1, (3, 3))]
    noise = random.normal(0, 8 if kind == "png" else 20, (TEXELS, TEXELS, 1))
    texels = numpy.clip(127 + 100 * numpy.stack(waves, -1) + noise, 0, 255).astype("u1")
    out = io.BytesIO()
    Image.fromarray(texels).save(out, kind, **({"quality": 95} if kind == "jpeg" else {}))
    return out.getvalue()


def main(file, kind="png"):
    v, u = (axis.ravel().astype("f4") / (SIDE - 1) for axis in numpy.mgrid[0:SIDE, 0:SIDE])
    height = 0.1 * numpy.sin(9 * u) * numpy.cos(7 * v)
    slopes = [-0.9 * numpy.cos(9 * u) * numpy.cos(7 * v), numpy.ones_like(u), 0.7 * numpy.sin(9 * u) * numpy.sin(7 * v)]
    normals = numpy.stack(slopes, -1)
    normals /= numpy.linalg.norm(normals, axis=1, keepdims=True)
    at = numpy.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    a, b, c, d = (part.ravel() for part in (at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]))
    triangles = numpy.stack([a, d, b, b, d, c], -1).astype("<u4")
    positions = numpy.stack([u, height, v], -1)
    arrays = [positions, normals, numpy.stack([u, v], -1)]
    parts = [array.astype("<f4").tobytes() for array in arrays] + [triangles.tobytes()]
    parts += [picture(seed, kind) for seed in range(4)]
    binary, views = b"", []
    for part in parts:
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(part)})
        binary += part + b"\0" * (-len(part) % 4)
    accessor = lambda view, kind, count, component=5126: {
        "bufferView": view, "componentType": component, "count": count, "type": kind}
    accessors = [accessor(0, "VEC3", SIDE * SIDE), accessor(1, "VEC3", SIDE * SIDE), accessor(2, "VEC2", SIDE * SIDE)]
    accessors.append(accessor(3, "SCALAR", triangles.size, 5125))
    accessors[0] |= {"min": positions.min(0).tolist(), "max": positions.max(0).tolist()}
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(binary)}],
        "bufferViews": views,
        "accessors": accessors,
        "images": [{"bufferView": 4 + i, "mimeType": f"image/{kind}"} for i in range(4)],
        "textures": [{"source": i} for i in range(4)],
        "materials": [{
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 1}},
            "normalTexture": {"index": 2},
            "emissiveTexture": {"index": 3},
            "emissiveFactor": [0.1, 0.1, 0.1],
        }],
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3, "material": 0}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with open(file, "wb") as out:
        out.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)))
        out.write(struct.pack("<I4s", len(text), b"JSON") + text)
        out.write(struct.pack("<I4s", len(binary), b"BIN\0") + binary)


main(*sys.argv[1:])
