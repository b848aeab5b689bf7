#!/usr/bin/python3
"""Times VTK's CPU ray caster (vtkFixedPointVolumeRayCastMapper) in the same way as `cvol bench render` times cvol.

One process renders one volume with one transfer function and one mode. The views are those of cvol: azimuths 15 +
360 i / views at elevation 20, parallel projection, half the picture's height equal to half the diagonal of the box
of sample centres, +z up. A view's time is the best of its repeats; min and median are over the views; a first
picture is not counted. Prints one JSON object.

Without DISPLAY it starts its own Xvfb and ends it.
"""
import argparse
import json
import math
import os
import signal
import statistics
import subprocess
import sys
import time


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('raw', help='little-endian samples, x fastest')
    parser.add_argument('--dims', required=True, metavar='NXxNYxNZ')
    parser.add_argument('--type', required=True, help='uint8 int8 uint16 int16 float32')
    parser.add_argument('--spacing', default='1,1,1', metavar='SX,SY,SZ')
    parser.add_argument('--transfer', metavar='FILE', help='transfer function in the form of cvol '
                        '(mode composite needs one)')
    parser.add_argument('--mode', default='composite', choices=['composite', 'xray', 'mip'])
    parser.add_argument('--size', type=int, default=512, help='pixels a side (default 512)')
    parser.add_argument('--views', type=int, default=12, help='views around the volume '
                        '(default 12)')
    parser.add_argument('--repeat', type=int, default=3, help='pictures of each view (default 3)')
    parser.add_argument('--threads', type=int, default=1, help='default 1')
    parser.add_argument('--step', type=float, default=1, help='sample distance along the ray, in '
                        'mean sample spacings (default 1)')
    parser.add_argument('--image-step', type=float, default=1, help='pixels from ray to ray '
                        '(default 1); between them colours are interpolated')
    parser.add_argument('--shrink', type=int, default=1, metavar='N', help='render means of N^3 '
                        'samples, in the place of the volume (default 1)')
    parser.add_argument('--shade', action='store_true', help='Phong, a light at the camera, '
                        'ambient 0.1, diffuse 0.7, specular 0.2, shininess 10')
    parser.add_argument('--png', metavar='DIR', help='write the pictures, DIR/view_00.png ...')
    arguments = parser.parse_args()
    if arguments.mode == 'composite' and not arguments.transfer:
        parser.error('mode composite needs --transfer FILE')
    return arguments


# ---- the display --------------------------------------------------------------------------------

def start_display():
    """Starts an Xvfb on a free display and sets DISPLAY; returns None if DISPLAY is set already."""
    if os.environ.get('DISPLAY'):
        return None
    read_end, write_end = os.pipe()
    try:
        server = subprocess.Popen(['Xvfb', '-displayfd', str(write_end), '-screen', '0',
                                   '1280x1280x24', '-nolisten', 'tcp', '-noreset'],
                                  pass_fds=[write_end], stderr=subprocess.DEVNULL)
    except FileNotFoundError:
        sys.exit('vtk_render.py: no DISPLAY and no Xvfb (Debian package xvfb)')
    os.close(write_end)
    with os.fdopen(read_end) as answer:
        number = answer.readline().strip()
    if not number:
        stop_display(server)
        sys.exit('vtk_render.py: Xvfb did not start')
    os.environ['DISPLAY'] = ':' + number
    return server


def stop_display(server):
    if server:
        server.terminate()
        server.wait()


# ---- the scene ----------------------------------------------------------------------------------

def read_samples(arguments):
    import numpy
    dims = [int(n) for n in arguments.dims.split('x')]
    kind = numpy.dtype(arguments.type).newbyteorder('<')
    samples = numpy.fromfile(arguments.raw, dtype=kind)
    if samples.size != math.prod(dims):
        sys.exit(f'{arguments.raw}: has {samples.size} samples, {arguments.dims} are '
                 f'{math.prod(dims)}')
    return samples, dims, [float(s) for s in arguments.spacing.split(',')]


def shrink_samples(samples, dims, n):
    """Returns means of n^3 samples (fewer at the ends) in the type of the samples."""
    import numpy
    volume = samples.reshape(dims[::-1])
    padded = numpy.pad(volume, [(0, -size % n) for size in volume.shape], mode='edge')
    z, y, x = (size // n for size in padded.shape)
    means = padded.reshape(z, n, y, n, x, n).mean(axis=(1, 3, 5), dtype=numpy.float32)
    if samples.dtype.kind in 'iu':
        means = numpy.rint(means)
    return numpy.ascontiguousarray(means.astype(samples.dtype)).ravel(), [x, y, z]


def make_image(samples, dims, spacing, n):
    """Returns the image of samples n times as far apart as `spacing`, each in the centre of its group."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkImageData
    image = vtkImageData()
    image.SetDimensions(dims)
    image.SetSpacing([n * s for s in spacing])
    image.SetOrigin([0.5 * (n - 1) * s for s in spacing])
    image.GetPointData().SetScalars(numpy_to_vtk(samples, deep=0))
    return image


def make_property(arguments, samples, dims, spacing):
    """Linear interpolation, opacity per mean sample spacing."""
    from vtkmodules.vtkCommonDataModel import vtkPiecewiseFunction
    from vtkmodules.vtkRenderingCore import vtkColorTransferFunction, vtkVolumeProperty
    opacity, color = vtkPiecewiseFunction(), vtkColorTransferFunction()
    if arguments.mode == 'composite':
        with open(arguments.transfer, encoding='utf-8') as file:
            points = json.load(file)['points']
        for value, red, green, blue, alpha in points:
            opacity.AddPoint(value, alpha)
            color.AddRGBPoint(value, red, green, blue)
    else:
        # VTK computes sums along rays, not means; the gain only prevents saturation.
        low, high = float(samples.min()), float(samples.max())
        gain = 1 if arguments.mode == 'mip' else 2 / math.hypot(*dims)
        opacity.AddPoint(low, 1 if arguments.mode == 'mip' else 0)
        opacity.AddPoint(high, gain)
        color.AddRGBPoint(low, *([0] * 3 if arguments.mode == 'mip' else [1] * 3))
        color.AddRGBPoint(high, 1, 1, 1)
    look = vtkVolumeProperty()
    look.SetScalarOpacity(opacity)
    look.SetColor(color)
    look.SetInterpolationTypeToLinear()
    look.SetScalarOpacityUnitDistance(sum(spacing) / 3)
    look.SetShade(arguments.shade)
    look.SetAmbient(0.1)
    look.SetDiffuse(0.7)
    look.SetSpecular(0.2)
    look.SetSpecularPower(10)
    return look


def make_mapper(arguments, image, spacing):
    """Renders with the given rays and steps: VTK must not coarsen them to reach a frame rate."""
    from vtkmodules.vtkRenderingVolume import vtkFixedPointVolumeRayCastMapper
    step = arguments.step * arguments.shrink * sum(spacing) / 3
    mapper = vtkFixedPointVolumeRayCastMapper()
    mapper.SetInputData(image)
    mapper.SetNumberOfThreads(arguments.threads)
    mapper.SetAutoAdjustSampleDistances(0)
    mapper.SetLockSampleDistanceToInputSpacing(0)
    mapper.SetImageSampleDistance(arguments.image_step)
    mapper.SetSampleDistance(step)
    mapper.SetInteractiveSampleDistance(step)
    mapper.SetIntermixIntersectingGeometry(0)  # no geometry: VTK need not read the depth buffer
    if arguments.mode == 'mip':
        mapper.SetBlendModeToMaximumIntensity()
    elif arguments.mode == 'xray':
        mapper.SetBlendModeToAdditive()
    else:
        mapper.SetBlendModeToComposite()
    return mapper


def make_window(size):
    from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow
    renderer, window = vtkRenderer(), vtkRenderWindow()
    renderer.SetBackground(0, 0, 0)
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(size, size)
    window.AddRenderer(renderer)
    return renderer, window


def aim_camera(renderer, view, views, dims, spacing):
    extent = [(n - 1) * s for n, s in zip(dims, spacing)]
    centre = [e / 2 for e in extent]
    half = math.hypot(*extent) / 2
    azimuth, elevation = math.radians(15 + 360 * view / views), math.radians(20)
    eye = (math.cos(elevation) * math.sin(azimuth), -math.cos(elevation) * math.cos(azimuth),
           math.sin(elevation))
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    camera.SetFocalPoint(centre)
    camera.SetPosition([c + 4 * half * e for c, e in zip(centre, eye)])
    camera.SetViewUp(0, 0, 1)
    camera.SetParallelScale(half)
    camera.SetClippingRange(half, 8 * half)


# ---- measuring ----------------------------------------------------------------------------------

def render(window):
    """Returns wall and processor milliseconds of one picture."""
    cpu, wall = time.process_time(), time.perf_counter()
    window.Render()
    window.WaitForCompletion()
    return 1e3 * (time.perf_counter() - wall), 1e3 * (time.process_time() - cpu)


def write_png(window, path):
    from PIL import Image
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkUnsignedCharArray
    width, height = window.GetSize()
    pixels = vtkUnsignedCharArray()
    window.GetPixelData(0, 0, width - 1, height - 1, 0, pixels, 0)
    rows = vtk_to_numpy(pixels).reshape(height, width, 3)[::-1]
    Image.fromarray(rows.copy()).save(path)


def owner(module):
    """Returns the Debian package of a module, or ''."""
    try:
        answer = subprocess.run(['dpkg-query', '--search', module.__file__], check=False,
                                capture_output=True, text=True).stdout
    except FileNotFoundError:
        return ''
    return answer.partition(':')[0]


def peak_rss_mb():
    """Returns the peak of this process: getrusage would include its parent's before exec."""
    with open('/proc/self/status', encoding='ascii') as status:
        for line in status:
            if line.startswith('VmHWM'):
                return int(line.split()[1]) / 1024
    return 0.0


def over_views(times, views):
    """Returns {min, median, all} of times[repeat * views + view], as `cvol bench render` prints them."""
    best = [min(times[view::views]) for view in range(views)]
    return {'min': min(best), 'median': statistics.median(best), 'all': times}


def measure(arguments):
    import vtkmodules
    import vtkmodules.vtkRenderingOpenGL2  # noqa: F401 (registers classes with VTK's factories)
    import vtkmodules.vtkRenderingVolumeOpenGL2  # noqa: F401
    from vtkmodules.vtkCommonCore import vtkVersion
    from vtkmodules.vtkRenderingCore import vtkVolume
    renderer, window = make_window(arguments.size)
    window.Render()
    blank_ms = min(render(window)[0] for _ in range(5))
    base_mb = peak_rss_mb()

    start = time.perf_counter()
    samples, dims, spacing = read_samples(arguments)
    volume = vtkVolume()
    fewer, sizes = (shrink_samples(samples, dims, arguments.shrink) if arguments.shrink > 1
                    else (samples, dims))
    mapper = make_mapper(arguments, make_image(fewer, sizes, spacing, arguments.shrink), spacing)
    volume.SetMapper(mapper)
    volume.SetProperty(make_property(arguments, samples, dims, spacing))
    renderer.AddViewProp(volume)
    load_ms = 1e3 * (time.perf_counter() - start)

    aim_camera(renderer, 0, arguments.views, dims, spacing)
    first_ms = render(window)[0]
    wall, cpu, mapper_only = [], [], []
    for i in range(arguments.views * arguments.repeat):
        aim_camera(renderer, i % arguments.views, arguments.views, dims, spacing)
        times = render(window)
        wall.append(times[0])
        cpu.append(times[1])
        mapper_only.append(1e3 * mapper.GetTimeToDraw())
        if arguments.png and i < arguments.views:
            write_png(window, os.path.join(arguments.png, f'view_{i:02d}.png'))
    frame = over_views(wall, arguments.views)
    return {'frame_ms': frame, 'cpu_ms': over_views(cpu, arguments.views)['median'],
            'mapper_ms': over_views(mapper_only, arguments.views)['median'],
            'blank_ms': blank_ms, 'load_ms': load_ms, 'first_frame_ms': first_ms,
            'peak_rss_mb': peak_rss_mb(), 'base_rss_mb': base_mb, 'voxels': samples.size,
            'ns_per_voxel': 1e6 * frame['median'] / samples.size, 'mode': arguments.mode,
            'size': arguments.size, 'views': arguments.views, 'threads': arguments.threads,
            'step': arguments.step, 'version': vtkVersion.GetVTKVersion(),
            'package': owner(vtkmodules)}


def main():
    arguments = parse_arguments()
    if arguments.png:
        os.makedirs(arguments.png, exist_ok=True)
    # Mesa's rasteriser, which displays the picture, gets no more threads than VTK.
    os.environ['LP_NUM_THREADS'] = str(arguments.threads if arguments.threads > 1 else 0)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    server = start_display()
    try:
        print(json.dumps(measure(arguments)))
    finally:
        stop_display(server)


if __name__ == '__main__':
    main()
