"""Shared by scripts that compare cvol with VTK: times of pictures, by the clock and the processor."""
import os
import resource
import statistics

from tables import Failed, run, run_json, say
from volumes import BENCH

VTK = os.path.join(BENCH, 'peers', 'vtk_render.py')


def have_vtk(arguments):
    if arguments.no_vtk:
        return False
    try:
        run(['/usr/bin/python3', '-c', 'import vtkmodules, numpy'])
        return True
    except (OSError, Failed):
        say('VTK skipped: /usr/bin/python3 has no vtk and numpy (scripts/dependencies.sh bench)')
        return False


def child_cpu_s():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def time_vtk(raw, about, options):
    return run_json([VTK, raw, '--dims', 'x'.join(map(str, about['dims'])), '--type',
                     about['type'], '--spacing', ','.join(map(str, about['spacing']))] + options)


def first_picture_ms(result):
    """Runs a VTK process: reads the volume, prepares it and renders the first picture."""
    return result['load_ms'] + result['first_frame_ms']


def median_of(results, *keys):
    def pick(result):
        for key in keys:
            result = result[key]
        return result
    return statistics.median(pick(result) for result in results)


def frame_ratios(ours, theirs):
    """Returns their time divided by ours in each round, for the median views."""
    return [b['frame_ms']['median'] / a['frame_ms']['median'] for a, b in zip(ours, theirs)]
