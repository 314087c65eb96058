#!/usr/bin/env python3
"""Compares our pictures of volumes with those of VTK.

Needs Python 3 with vtk and numpy; no display, where VTK finds EGL or OSMesa (else xvfb-run):

    python3 -m venv VENV && VENV/bin/pip install vtk numpy

A picture by volume ray casting (vtkFixedPointVolumeRayCastMapper, a single thread, samples at a fixed distance, post-classified),
with a transfer function in our text format (see mobula::load::load_transfer), and the time per frame:

    compare.py dvr VOLUME.nrrd TRANSFER.txt --eye X,Y,Z --at X,Y,Z --fov DEGREES --step LENGTH -o vtk.png [--shaded]

The same picture by Mobula (whose eye looks with y or z up), and how far both are apart:

    mobula render VOLUME.nrrd --transfer TRANSFER.txt --eye X,Y,Z --at X,Y,Z --fov DEGREES --up z \\
        --size 512x512 --samples 1 --background black -o ours.png
    compare.py dvr ... -o vtk.png --compare ours.png

An iso-surface (vtkFlyingEdges3D, rays of the pixels' centres through vtkStaticCellLocator) and its distances from the eye; Mobula's
by its renderer `depth`, whose picture says s / (s + distance), s being the diagonal of the volume:

    compare.py iso VOLUME.nrrd 300 --eye X,Y,Z --at X,Y,Z --fov DEGREES -o vtk.png --compare ours.png
    mobula render VOLUME.nrrd --iso 300 --renderer depth ... -o ours.png

Pictures of `dvr` are compared as linear values from 0 to 1: VTK is given the linear colours of the transfer function and blends
them, as Mobula does; Mobula's PNG is decoded from sRGB. Both have 8 bits a channel, so that equal pictures may differ by 1/500 where
they are bright. Told are the mean and the 95th percentile of the absolute difference, over all channels of all pixels that are not
black in both, and the greatest. VTK's PNG file is written as sRGB, for people. What to expect: a march in double precision along the
same rays with the same step (0.25 mm in a head, the functions `bone` and `skin`, unshaded) is 0.008 to 0.009 from VTK in the mean,
0.02 at the 95th percentile, 0.001 in the signed mean: that is how exact VTK's fixed-point numbers are.

Distances are compared where both have a hit, by the mean and the 95th percentile of the absolute difference in units of the file. The
8 bits of our picture tell only some millimetres of a head apart: how many pixels are within half a byte is told, and the median of
the signed difference, which is much finer. Pixels that only one of both hits are counted.

The extinction e of the transfer function becomes VTK's opacity 1 - exp(-e) for a unit distance of 1, at 4096 values of the range.
"""

import argparse
import gzip
import math
import platform
import statistics
import sys
import time

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

TYPES = {"uint8": "u1", "uchar": "u1", "unsigned char": "u1", "int16": "i2", "short": "i2", "uint16": "u2", "ushort": "u2",
         "unsigned short": "u2", "float": "f4"}


def read_nrrd(path):
    """The voxels (z, y, x), the spacing and the origin of an NRRD file with raw or gzip data of its own."""
    with open(path, "rb") as file:
        data = file.read()
    if data.startswith(b"\x1f\x8b"):
        data = gzip.decompress(data)
    head, _, body = data.partition(b"\n\n")
    lines = head.decode("latin1").replace("\r", "").split("\n")
    if not lines[0].startswith("NRRD"):
        sys.exit(f"{path}: this is no NRRD file")
    fields = dict(line.split(": ", 1) for line in lines[1:] if ": " in line and not line.startswith("#"))
    sizes = [int(word) for word in fields["sizes"].split()]
    if len(sizes) != 3 or "data file" in fields:
        sys.exit(f"{path}: only volumes of three dimensions with data in the same file are read here")
    if fields["encoding"] in ("gzip", "gz"):
        body = gzip.decompress(body)
    order = ">" if fields.get("endian") == "big" else "<"
    voxels = np.frombuffer(body, order + TYPES[fields["type"]], count=math.prod(sizes)).reshape(sizes[::-1])
    if "space directions" in fields:
        axes = [[float(x) for x in word.strip("()").split(",")] for word in fields["space directions"].split()]
        if any(axes[i][j] for i in range(3) for j in range(3) if i != j):
            sys.exit(f"{path}: only grids along the axes are read here")
        spacing = [axes[i][i] for i in range(3)]
    else:
        spacing = [float(word) for word in fields.get("spacings", "1 1 1").split()]
    origin = [float(x) for x in fields["space origin"].strip("()").split(",")] if "space origin" in fields else [0.0] * 3
    return voxels.astype(voxels.dtype.newbyteorder("=")), spacing, origin


def image(voxels, spacing, origin):
    """As VTK holds it."""
    grid = vtk.vtkImageData()
    grid.SetDimensions(voxels.shape[::-1])
    grid.SetSpacing(spacing)
    grid.SetOrigin(origin)
    grid.GetPointData().SetScalars(numpy_to_vtk(voxels.ravel(), deep=True))
    return grid


def linear_of(srgb):
    """From the sRGB curve to linear values."""
    srgb = np.asarray(srgb, float)
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def srgb_of(linear):
    """And back."""
    linear = np.clip(linear, 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def read_transfer(path, value_range, longest_side):
    """Values, linear colours and extinction of a transfer function, resolved for a volume."""
    scale, points = {"values": "absolute", "lengths": "absolute"}, []
    with open(path, encoding="utf-8") as file:
        lines = [line.split("#")[0].split() for line in file]
    lines = [words for words in lines if words]
    if lines[0] != ["mobula", "transfer", "1"]:
        sys.exit(f"{path}: this is no transfer function")
    for words in lines[1:]:
        if words[0] in scale:
            scale[words[0]] = words[1]
        else:
            points.append([float(word) for word in words])
    points = np.array(points)
    values, colors, extinction = points[:, 0], linear_of(points[:, 1:4]), points[:, 4]
    if scale["values"] == "relative":
        values = value_range[0] * (1 - values) + value_range[1] * values
    if scale["lengths"] == "relative":
        extinction = extinction / longest_side
    return values, colors, extinction


class View:
    """A window that is not shown, and its camera."""

    def __init__(self, options):
        self.window = vtk.vtkRenderWindow()
        self.window.SetOffScreenRendering(1)
        self.window.SetMultiSamples(0)
        self.window.SetSize(*options.size)
        self.renderer = vtk.vtkRenderer()
        self.renderer.SetBackground(0, 0, 0)
        self.window.AddRenderer(self.renderer)
        camera = self.renderer.GetActiveCamera()
        camera.SetPosition(options.eye)
        camera.SetFocalPoint(options.at)
        camera.SetViewUp(options.up)
        camera.SetViewAngle(options.fov)

    def frame(self):
        """Renders, and gives the bytes, the top row first."""
        self.renderer.ResetCameraClippingRange()
        self.window.Render()
        grab = vtk.vtkWindowToImageFilter()
        grab.SetInput(self.window)
        grab.ReadFrontBufferOff()
        grab.SetInputBufferTypeToRGB()
        grab.Update()
        got = grab.GetOutput()
        width, height, _ = got.GetDimensions()
        return vtk_to_numpy(got.GetPointData().GetScalars()).reshape(height, width, 3)[::-1]


def write_png(path, rgb):
    """Bytes, the top row first."""
    height, width, _ = rgb.shape
    picture = vtk.vtkImageData()
    picture.SetDimensions(width, height, 1)
    picture.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(rgb[::-1]).reshape(-1, 3), deep=True))
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(path)
    writer.SetInputData(picture)
    writer.Write()


def read_png(path):
    """Bytes of red, green and blue, the top row first."""
    reader = vtk.vtkPNGReader()
    if not reader.CanReadFile(path):
        sys.exit(f"{path}: this is no PNG file")
    reader.SetFileName(path)
    reader.Update()
    got = reader.GetOutput()
    width, height, _ = got.GetDimensions()
    pixels = vtk_to_numpy(got.GetPointData().GetScalars()).reshape(height, width, -1)[::-1]
    return pixels[:, :, :3]


def tell(what, difference, unit=""):
    """The numbers that differences are judged by."""
    if difference.size == 0:
        sys.exit(f"{what}: there is nothing to compare")
    mean, high, most = difference.mean(), np.percentile(difference, 95), difference.max()
    print(f"{what}: mean {mean:.5f}{unit}, 95th percentile {high:.5f}{unit}, greatest {most:.5f}{unit}")


def machine():
    """What the times are of."""
    model = platform.processor() or platform.machine()
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            model = next(line.split(":", 1)[1].strip() for line in file if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    return f"{model}, {platform.system()} {platform.release()}, VTK {vtk.vtkVersion.GetVTKVersion()}, one thread"


def dvr(options):
    """A picture by volume ray casting."""
    voxels, spacing, origin = read_nrrd(options.volume)
    low, high = float(voxels.min()), float(voxels.max())
    longest = max((n - 1) * h for n, h in zip(voxels.shape[::-1], spacing))
    values, colors, extinction = read_transfer(options.what, (low, high), longest)

    color, opacity = vtk.vtkColorTransferFunction(), vtk.vtkPiecewiseFunction()
    color.SetColorSpaceToRGB()
    color.AllowDuplicateScalarsOn()
    opacity.AllowDuplicateScalarsOn()
    for value in np.union1d(np.linspace(low, high, 4096), values):
        r, g, b = (np.interp(value, values, colors[:, k]) for k in range(3))
        color.AddRGBPoint(value, r, g, b)
        opacity.AddPoint(value, 1 - math.exp(-np.interp(value, values, extinction)))

    look = vtk.vtkVolumeProperty()
    look.SetColor(color)
    look.SetScalarOpacity(opacity)
    look.SetScalarOpacityUnitDistance(1.0)
    look.SetInterpolationTypeToLinear()
    look.SetShade(options.shaded)
    look.SetAmbient(options.ambient)
    look.SetDiffuse(1 - options.ambient)
    look.SetSpecular(0)

    mapper = vtk.vtkFixedPointVolumeRayCastMapper()
    mapper.SetInputData(image(voxels, spacing, origin))
    mapper.SetNumberOfThreads(1)
    mapper.SetAutoAdjustSampleDistances(0)
    mapper.SetLockSampleDistanceToInputSpacing(0)
    mapper.SetSampleDistance(options.step)
    mapper.SetImageSampleDistance(1)
    mapper.IntermixIntersectingGeometryOff()

    volume = vtk.vtkVolume()
    volume.SetMapper(mapper)
    volume.SetProperty(look)
    view = View(options)
    view.renderer.AddVolume(volume)
    linear = view.frame() / 255.0
    times = []
    for _ in range(options.frames):
        # Only what is new is rendered.
        view.renderer.GetActiveCamera().Modified()
        volume.Modified()
        start = time.perf_counter()
        view.window.Render()
        times.append(1000 * (time.perf_counter() - start))
    print(f"machine: {machine()}")
    shaded = "shaded" if options.shaded else "unshaded"
    print(f"{shaded}, {options.size[0]} x {options.size[1]}, step {options.step:g}: "
          f"{statistics.median(times):.1f} ms per frame (median of {len(times)}, least {min(times):.1f})")
    if options.output:
        write_png(options.output, np.round(255 * srgb_of(linear)).astype(np.uint8))
    if options.compare:
        ours = linear_of(read_png(options.compare) / 255.0)
        if ours.shape != linear.shape:
            sys.exit(f"{options.compare}: another size of picture")
        seen = (ours > 0).any(axis=2) | (linear > 0).any(axis=2)
        print(f"pixels that are not black: {seen.sum()} of {seen.size}")
        tell("absolute difference of linear values", np.abs(ours - linear)[seen])


def iso(options):
    """An iso-surface, and distances to it."""
    voxels, spacing, origin = read_nrrd(options.volume)
    grid = image(voxels, spacing, origin)
    start = time.perf_counter()
    edges = vtk.vtkFlyingEdges3D()
    edges.SetInputData(grid)
    edges.SetValue(0, float(options.what))
    edges.ComputeNormalsOff()
    edges.ComputeGradientsOff()
    edges.Update()
    surface = edges.GetOutput()
    print(f"machine: {machine()}")
    print(f"{surface.GetNumberOfPolys()} triangles in {1000 * (time.perf_counter() - start):.0f} ms")
    locator = vtk.vtkStaticCellLocator()
    locator.SetDataSet(surface)
    locator.BuildLocator()

    eye, at, up = (np.array(v, float) for v in (options.eye, options.at, options.up))
    forward = (at - eye) / np.linalg.norm(at - eye)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    width, height = options.size
    half = math.tan(math.radians(options.fov) / 2)
    far = np.linalg.norm(np.array(grid.GetCenter()) - eye) + grid.GetLength()
    distance = np.full((height, width), np.inf)
    t, s, part, cell = vtk.mutable(0.0), vtk.mutable(0), vtk.mutable(0), vtk.mutable(0)
    point, coordinates = [0.0] * 3, [0.0] * 3
    for y in range(height):
        for x in range(width):
            toward = forward + half * ((2 * x + 1 - width) / height * right - (2 * y + 1 - height) / height * up)
            toward *= far / np.linalg.norm(toward)
            if locator.IntersectWithLine(eye, eye + toward, 0.0, t, point, coordinates, s, cell):
                distance[y, x] = float(t) * far
    size = grid.GetLength()
    if options.output:
        depth = srgb_of(size / (size + distance))
        write_png(options.output, np.repeat(np.round(255 * depth).astype(np.uint8)[:, :, None], 3, axis=2))
    hits = np.isfinite(distance)
    print(f"pixels with a hit: {hits.sum()} of {hits.size}")
    if options.compare:
        depth = read_png(options.compare)[:, :, 0].astype(float)
        if depth.shape != distance.shape:
            sys.exit(f"{options.compare}: another size of picture")

        def of_byte(byte):
            return size * (1 / np.maximum(linear_of(np.clip(byte, 0, 255) / 255.0), 1e-9) - 1)

        both = hits & (depth > 0)
        print(f"pixels that only VTK hits: {(hits & ~both).sum()}, that only we hit: {((depth > 0) & ~both).sum()}")
        difference = (of_byte(depth) - distance)[both]
        tell("absolute difference of distances", np.abs(difference))
        print(f"median of the signed difference: {np.median(difference):.5f}")
        half_byte = (of_byte(depth - 0.5) - of_byte(depth + 0.5))[both] / 2
        print(f"half a step of the picture's bytes there: mean {half_byte.mean():.5f}")
        within = np.abs(difference) <= half_byte + options.tolerance
        print(f"within half a step and {options.tolerance:g}: {100 * within.mean():.3f} %")


def main():
    def numbers(text):
        return tuple(float(word) for word in text.split(","))

    def size(text):
        return tuple(int(word) for word in text.split("x"))

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mode", choices=["dvr", "iso"])
    parser.add_argument("volume", help="an NRRD file")
    parser.add_argument("what", help="dvr: a transfer function; iso: a value")
    parser.add_argument("--eye", type=numbers, required=True)
    parser.add_argument("--at", type=numbers, required=True)
    parser.add_argument("--up", type=numbers, default=(0.0, 0.0, 1.0))
    parser.add_argument("--fov", type=float, default=30.0, help="vertical, in degrees")
    parser.add_argument("--size", type=size, default=(512, 512))
    parser.add_argument("--step", type=float, default=0.5, help="dvr: the distance between samples")
    parser.add_argument("--shaded", action="store_true", help="dvr: with a light at the eye")
    parser.add_argument("--ambient", type=float, default=0.2, help="dvr, shaded: the part that needs no light")
    parser.add_argument("--frames", type=int, default=7, help="dvr: how many are timed")
    parser.add_argument("--tolerance", type=float, default=0.05, help="iso: of a distance")
    parser.add_argument("-o", "--output", help="VTK's picture, a PNG file")
    parser.add_argument("--compare", help="our picture, a PNG file")
    options = parser.parse_args()
    {"dvr": dvr, "iso": iso}[options.mode](options)


if __name__ == "__main__":
    main()
