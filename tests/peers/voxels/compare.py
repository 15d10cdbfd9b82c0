"""Voxels of one sphere by tools for Python, and by the program beside this file, one after the other in one run.

    pip install numpy trimesh scipy vtk open3d
    python compare.py [--runs 5] [--size 256]

Each is timed from triangles in memory to voxels in memory; medians, a line of JSON each. The tools differ in what they call
a voxel of a surface, and so in how many they set.
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).parent


def measured(tool, what, runs, once):
    """Prints the median of some runs, behind one that does not count."""
    count = once()
    times = []
    for _ in range(runs):
        began = time.perf_counter()
        count = once()
        times.append(1e3 * (time.perf_counter() - began))
    told = {"tool": tool, "what": what, "milliseconds": statistics.median(times), "set": int(count)}
    print(json.dumps(told), flush=True)


def by_trimesh(path, edge, runs):
    import trimesh

    mesh = trimesh.load(path, process=False)
    measured("trimesh", "surface", runs, lambda: mesh.voxelized(edge).filled_count)
    measured("trimesh", "solid", runs, lambda: mesh.voxelized(edge).fill().filled_count)


def by_vtk(path, minimum, edge, size, runs):
    import vtk

    reader = vtk.vtkOBJReader()
    reader.SetFileName(str(path))
    reader.Update()
    mesh = reader.GetOutput()

    def solid():
        stencil = vtk.vtkPolyDataToImageStencil()
        stencil.SetInputData(mesh)
        stencil.SetOutputOrigin(*[c + edge / 2 for c in minimum])
        stencil.SetOutputSpacing(edge, edge, edge)
        stencil.SetOutputWholeExtent(0, size - 1, 0, size - 1, 0, size - 1)
        image = vtk.vtkImageStencilToImage()
        image.SetInputConnection(stencil.GetOutputPort())
        image.SetOutputScalarTypeToUnsignedChar()
        image.SetInsideValue(1)
        image.SetOutsideValue(0)
        image.Update()
        from vtk.util.numpy_support import vtk_to_numpy

        return vtk_to_numpy(image.GetOutput().GetPointData().GetScalars()).sum(dtype="int64")

    measured("vtk", "solid", runs, solid)


def by_open3d(path, minimum, edge, size, runs):
    import open3d

    mesh = open3d.io.read_triangle_mesh(str(path))
    maximum = [c + edge * size for c in minimum]

    def surface():
        return open3d.geometry.VoxelGrid.create_from_triangle_mesh_within_bounds(mesh, edge, minimum, maximum)

    # Making a list of the voxels, to count them, takes longer than finding them: it is left out of the time.
    found = len(surface().get_voxels())
    measured("open3d", "surface", runs, lambda: (surface(), found)[1])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--size", type=int, default=256)
    arguments = parser.parse_args()
    runs, size = arguments.runs, arguments.size

    # The grid that shadowgraph puts around a sphere of radius 1: half a voxel of margin.
    edge = 2 / (size - 1)
    minimum = [-edge * size / 2] * 3

    program = ["cargo", "run", "--release", "--quiet", "--package", "shadowgraph-voxel-peers", "--"]
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "sphere.obj"
        subprocess.run([*program, "--obj", path], cwd=HERE, check=True)
        subprocess.run([*program, "--runs", str(runs), "--size", str(size)], cwd=HERE, check=True)
        by_open3d(path, minimum, edge, size, runs)
        by_vtk(path, minimum, edge, size, runs)
        by_trimesh(path, edge, 1)


if __name__ == "__main__":
    sys.exit(main())
