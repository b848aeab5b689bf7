"""Run by pvbatch (test_paraview.py): reads files by the reader, and writes what ParaView got into a folder.

usage: pvbatch paraview_script.py READER FOLDER [PICTURE]
"""

import inspect
import json
import os
import sys

# ParaView 5.11.0 uses this function, which Python 3.11 does not have: without it Python plugins do not load.
if not hasattr(inspect, "getargspec"):
    inspect.getargspec = inspect.getfullargspec

import numpy as np
from paraview import servermanager
from paraview import simple as pv
from vtk.util.numpy_support import vtk_to_numpy

reader, folder = sys.argv[1:3]
pv.LoadPlugin(reader, remote=False, ns=globals())
results = {}


def describe(source, name):
    """Fetches the data, saves its arrays, and keeps its geometry."""
    image = servermanager.Fetch(source)
    matrix = image.GetDirectionMatrix()
    points = image.GetPointData()
    shape = image.GetDimensions()[::-1]
    results[name] = {
        "extent": image.GetExtent(), "spacing": image.GetSpacing(), "origin": image.GetOrigin(),
        "direction": [matrix.GetElement(i, k) for i in range(3) for k in range(3)],
        "times": list(getattr(source, "TimestepValues", []) or []),
        "corner": image.GetPoint(image.GetNumberOfPoints() - 1), "active": points.GetScalars().GetName(),
    }  # fmt: skip
    for k in range(points.GetNumberOfArrays()):
        array = points.GetArray(k)
        more = (array.GetNumberOfComponents(),) if array.GetNumberOfComponents() > 1 else ()
        np.save(f"{folder}/{name}-{array.GetName()}.npy", vtk_to_numpy(array).reshape(shape + more))


def read_files():
    """Volumes, parts, levels, series, colours, and files that are wrong."""
    scan = pv.OpenDataFile(f"{folder}/scan.cvol")
    describe(scan, "scan")
    part = pv.ExtractSubset(Input=scan, VOI=[10, 30, 5, 9, 40, 60])
    describe(part, "part")
    scan.Level = 1
    describe(scan, "coarse")
    scan.Level = 3
    describe(scan, "coarsest")

    run = pv.OpenDataFile(f"{folder}/run.cvol")
    for time in (0, 0.7, 9):
        pv.UpdatePipeline(time, run)
        describe(run, f"run{time}")
    run.Channels = ["run GFP"]
    pv.UpdatePipeline(2, run)
    describe(run, "chosen")
    describe(pv.OpenDataFile(f"{folder}/colours.cvol"), "colours")

    for name in ("damaged", "plane"):
        wrong = pv.OpenDataFile(f"{folder}/{name}.cvol")
        wrong.UpdatePipeline()


def draw(path):
    """A picture by volume rendering."""
    head = pv.OpenDataFile(f"{folder}/head.cvol")
    head.UpdatePipeline()
    view = pv.CreateView("RenderView")
    view.ViewSize = [400, 400]
    view.OrientationAxesVisibility = 0
    display = pv.Show(head, view)
    display.SetRepresentationType("Volume")
    pv.ColorBy(display, ("POINTS", "head"))
    display.RescaleTransferFunctionToDataRange()
    view.ResetActiveCameraToNegativeY()
    view.ResetCamera()
    view.GetActiveCamera().Azimuth(35)
    pv.SaveScreenshot(path, view)


if len(sys.argv) > 3:
    draw(sys.argv[3])
else:
    read_files()
    with open(os.path.join(folder, "results.json"), "w", encoding="utf-8") as file:
        json.dump(results, file)
