"""Reader of .cvol files for ParaView: load this file by *Tools > Manage Plugins > Load New* (doc/recipes.md).

It makes image data with a point array for each channel. It decodes only the extent that a filter requests, such as
*Extract Subset*. Times of a series are time steps. The property *Level* chooses a coarser version of the volume, with
1/2, 1/4 or 1/8 of the samples along each axis. From a lossy file it reads only the coefficients of the level.
"""

# mypy: ignore-errors

from __future__ import annotations

import os
import sys

from paraview.util.vtkAlgorithm import smdomain, smproperty, smproxy
from paraview.vtk.util.numpy_support import numpy_to_vtk
from paraview.vtk.util.vtkAlgorithm import VTKPythonAlgorithmBase
from paraview.vtk.vtkCommonCore import vtkDataArraySelection, vtkOutputWindow
from paraview.vtk.vtkCommonDataModel import vtkDataObject, vtkImageData
from paraview.vtk.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as Pipeline

try:
    import cvol
except ImportError:  # ParaView's Python does not know the folder of the package, which holds this file.
    sys.path.append(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    import cvol

import numpy as np


def _array_name(path: str, listed: cvol.Contents, channel: int) -> str:
    """Name of a point array: that of the file, and of the channel if there are several."""
    name = os.path.splitext(os.path.basename(path))[0]
    if listed.channels == 1 or listed.colours:
        return name
    return f"{name} {listed.channel_names[channel] or channel}"


@smproxy.reader(
    name="CvolReader", label="Cvol Reader", extensions="cvol", file_description="Compressed volumes (cvol)"
)
class CvolReader(VTKPythonAlgorithmBase):
    """Image data of a .cvol file: spacing, origin and directions, time steps, an array for each channel."""

    def __init__(self) -> None:
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType="vtkImageData")
        self._path: str | None = None
        self._level = 0
        self._listed: cvol.Contents | None = None
        self._identity: tuple[int, ...] = ()
        self._volumes: dict[tuple[int, int], cvol.Volume] = {}
        self._chosen = vtkDataArraySelection()
        self._chosen.AddObserver("ModifiedEvent", lambda *_: self.Modified())

    # ---- properties -------------------------------------------------------------------------------

    @smproperty.stringvector(name="FileName", panel_visibility="never")
    @smdomain.filelist()
    def SetFileName(self, path: str) -> None:
        """The path of the .cvol file."""
        path = None if path in ("", "None") else path
        if path != self._path:
            self._path = path
            self._forget()
            self.Modified()

    @smproperty.intvector(name="Level", default_values=0)
    @smdomain.intrange(min=0, max=3)
    def SetLevel(self, level: int) -> None:
        """0: all samples. 1, 2, 3: 1/2, 1/4, 1/8 of them along each axis."""
        if level != self._level:
            self._level = level
            self.Modified()

    @smproperty.dataarrayselection(name="Channels")
    def GetDataArraySelection(self) -> vtkDataArraySelection:
        """The channels to read."""
        return self._chosen

    @smproperty.doublevector(name="TimestepValues", information_only="1", si_class="vtkSITimeStepsProperty")
    def GetTimestepValues(self) -> list[float] | None:
        """The times of a series."""
        listed = self._listed
        return list(listed.time_values) if listed is not None and listed.times > 1 else None

    # ---- the file ---------------------------------------------------------------------------------

    def _forget(self) -> None:
        for volume in self._volumes.values():
            volume.close()
        self._volumes.clear()
        self._listed = None

    def _list(self) -> cvol.Contents:
        """The times and channels, read again if the file was changed."""
        if self._path is None:
            raise ValueError("the reader has no file name")
        status = os.stat(self._path)
        identity = (status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns)
        if self._listed is None or identity != self._identity:
            self._forget()
            self._listed, self._identity = cvol.contents(self._path), identity
            names = [_array_name(self._path, self._listed, c) for c in range(self._listed.channels)]
            for name in dict.fromkeys(names):
                self._chosen.AddArray(name)
            for name in [self._chosen.GetArrayName(i) for i in range(self._chosen.GetNumberOfArrays())]:
                if name not in names:
                    self._chosen.RemoveArrayByName(name)
        return self._listed

    def _level_of(self, time: int, channel: int) -> cvol.Volume | cvol.Level:
        """The array of a time and channel at the chosen level, or at the coarsest one if there are fewer. Volumes of
        other times are closed."""
        for place in [place for place in self._volumes if place[0] != time]:
            self._volumes.pop(place).close()
        if (time, channel) not in self._volumes:
            self._volumes[time, channel] = cvol.open(self._path, time=time, channel=channel)
        volume = self._volumes[time, channel]
        if volume.ndim != 3:
            raise ValueError(f"{self._path}: has {volume.ndim} axes, must have 3")
        return volume.levels[min(self._level, len(volume.levels) - 1)]

    # ---- VTK's requests ---------------------------------------------------------------------------

    def RequestInformation(self, request, inputs, outputs) -> int:
        """Extent, spacing, origin, directions and time steps."""
        return self._guarded(self._describe, outputs.GetInformationObject(0))

    def RequestData(self, request, inputs, outputs) -> int:
        """The samples of the requested extent and time."""
        return self._guarded(self._read, outputs.GetInformationObject(0))

    def _guarded(self, step, information) -> int:
        """Runs a step. An error is one message in ParaView's window of messages, without a traceback."""
        try:
            step(information)
            return 1
        except (cvol.Error, OSError, ValueError) as error:
            vtkOutputWindow.GetInstance().DisplayErrorText(f"cvol: {error}\n")
            return 0

    def _describe(self, information) -> None:
        listed = self._list()
        level = self._level_of(0 if not self._volumes else next(iter(self._volumes))[0], 0)
        z, y, x = level.shape
        affine = level.affine
        spacing = level.spacing
        information.Set(Pipeline.WHOLE_EXTENT(), (0, x - 1, 0, y - 1, 0, z - 1), 6)
        information.Set(vtkDataObject.SPACING(), spacing[::-1], 3)
        information.Set(vtkDataObject.ORIGIN(), tuple(affine[:3, 3]), 3)
        directions = (affine[:3, :3] / spacing)[:, ::-1]  # columns: x, y, z
        information.Set(vtkDataObject.DIRECTION(), tuple(directions.ravel()), 9)
        information.Set(self.CAN_PRODUCE_SUB_EXTENT(), 1)
        for key in (Pipeline.TIME_STEPS(), Pipeline.TIME_RANGE()):
            information.Remove(key)
        if listed.times > 1:
            times = listed.time_values
            information.Set(Pipeline.TIME_STEPS(), times, len(times))
            information.Set(Pipeline.TIME_RANGE(), (min(times), max(times)), 2)

    def _time(self, information) -> int:
        """The number of the requested time: of the last one that is not later."""
        times = np.array(self._listed.time_values)
        if len(times) == 1 or not information.Has(Pipeline.UPDATE_TIME_STEP()):
            return 0
        wanted = information.Get(Pipeline.UPDATE_TIME_STEP())
        earlier = np.flatnonzero(times <= wanted)
        return int(earlier[times[earlier].argmax()]) if earlier.size else int(times.argmin())

    def _read(self, information) -> None:
        listed = self._list()
        output = vtkImageData.GetData(information)
        output.GetPointData().Initialize()  # VTK keeps the scalars of the last extent
        if not information.Has(vtkDataObject.SPACING()):
            raise ValueError(f"{self._path}: has no samples to show, see the message before")
        x0, x1, y0, y1, z0, z1 = extent = information.Get(Pipeline.UPDATE_EXTENT())
        output.SetExtent(extent)
        output.SetSpacing(information.Get(vtkDataObject.SPACING()))
        output.SetOrigin(information.Get(vtkDataObject.ORIGIN()))
        output.SetDirectionMatrix(information.Get(vtkDataObject.DIRECTION()))
        time = self._time(information)
        found: dict[str, list] = {}
        for channel in range(listed.channels):
            name = _array_name(self._path, listed, channel)
            if self._chosen.ArrayIsEnabled(name):
                samples = self._level_of(time, channel)[z0 : z1 + 1, y0 : y1 + 1, x0 : x1 + 1]
                found.setdefault(name, []).append(samples)
        for name, parts in found.items():  # the channels of one colour are the components of one array
            samples = parts[0].reshape(-1) if len(parts) == 1 else np.stack(parts, -1).reshape(-1, len(parts))
            array = numpy_to_vtk(np.ascontiguousarray(samples))  # which keeps the samples alive
            array.SetName(name)
            output.GetPointData().AddArray(array)
        if found:
            output.GetPointData().SetActiveScalars(next(iter(found)))
        if listed.times > 1:
            output.GetInformation().Set(vtkDataObject.DATA_TIME_STEP(), listed.time_values[time])
