#!/usr/bin/python3
"""Times of pictures by several processes of this computer (build with -DCVOL_BENCH=ON).

    bench/mpi_speed.py [--build build] [--ranks 1,2,3,4,8,16] [--size 1024x768] [--repeats 15] [--rounds 3]

Two tables. The first: putting the pictures of N parts together, by radix-k, by one MPI_Reduce of whole images and, if
the build found it, by IceT, in turns in the same processes; messages and bytes compared with the theory of radix-k.
The second: the stages of cvol-mpi render, of each picture of a turntable but the first. Of several rounds, each
measurement is the one that other programs disturbed least. With more processes than cores
all times are those of processes that share cores. bench/mpi_model.py reads the JSON file that this script writes next
to its table.
"""
import argparse
import json
import os
import statistics
import tempfile

from tables import RESULTS, machine, run, run_json
from volumes import ROOT

STAGES = ('draw_s', 'all_cpu_s', 'wait_s', 'composite_s', 'gather_s', 'warp_s')


def prepare_environment():
    """For Open MPI: in a container, as root, with more processes than cores, without ssh."""
    os.environ.update(OMP_WAIT_POLICY='passive', OMPI_ALLOW_RUN_AS_ROOT='1',
                      OMPI_ALLOW_RUN_AS_ROOT_CONFIRM='1', OMPI_MCA_rmaps_base_oversubscribe='1',
                      OMPI_MCA_plm_rsh_agent='sh', OMPI_MCA_btl_vader_single_copy_mechanism='none')


def theory(row):
    """Returns messages, and bytes if all pixels of all parts were sent.

    In a round with factor k each process sends k - 1 messages, and (k - 1)/k of its piece; then there are 1/k as many
    copies of the image. In the gather process 0 gets all but its own piece.
    """
    members, pixels = row['members'], row['width'] * row['height']
    folded, copies = row['processes'] - members, members
    messages, sent = folded + members - 1, pixels * folded + pixels * (1 - 1 / members)
    for k in row['factors']:
        messages += members * (k - 1)
        copies //= k
        sent += copies * (k - 1) * pixels
    return messages, sent * 16


def composite(a, ranks):
    width, height = a.size.split('x')
    return run_json([a.launcher, '-n', str(ranks), os.path.join(a.build, 'bench', 'compositing_speed'),
                     width, height, str(a.repeats)])


def least_disturbed(rows):
    """Of several rounds, the one that took the least time in all ways together."""
    return min(rows, key=lambda row: sum(row[way]['total_s']['min'] for way in ('radix_k', 'reduce', 'icet')
                                         if way in row))


def render(a, ranks, path, folder):
    """Returns the stages of the pictures of a turntable."""
    return run_json([a.launcher, '-n', str(ranks), os.path.join(a.build, 'cvol-mpi'), 'render', path, '-o',
                     os.path.join(folder, 'turn-{n}.png'), '--turntable', '7', '--size', a.size,
                     '--threads', '1', '--json'])['stages']


def typical_picture(ranks, rounds):
    """Returns medians over pictures 2 to 7, of each in the round where it took the least time."""
    frames = [min(same, key=lambda frame: frame['total_s']) for same in zip(*rounds)]
    row = {key: statistics.median(frame[key] for frame in frames[1:]) for key in frames[0]}
    row['read_s'] = min(stages[0]['read_s'] for stages in rounds)
    row['processes'] = ranks
    return row


def ms(seconds):
    return f'{1e3 * seconds:.1f}'


def compositing_table(rows):
    with_icet = 'icet' in rows[0]
    lines = ['| processes | factors | radix-k ms | of it gather | MPI_Reduce ms |' +
             (' IceT ms |' if with_icet else '') + ' messages | theory | MB | whole images MB |' +
             (' IceT MB |' if with_icet else ''),
             '|' + '---|' * (11 if with_icet else 9)]
    for row in rows:
        ours = row['radix_k']
        messages, whole = theory(row)

        def times(key, row=row):
            return f"{ms(row[key]['total_s']['min'])} / {ms(row[key]['total_s']['median'])}"
        lines.append(
            f"| {row['processes']} | {' x '.join(map(str, row['factors'])) or '-'} | {times('radix_k')} | "
            f"{ms(ours['gather_s']['median'])} | {times('reduce')} | " +
            (f"{times('icet')} | " if with_icet else '') +
            f"{ours['messages']} | {messages} | {ours['bytes'] / 1e6:.1f} | {whole / 1e6:.1f} |" +
            (f" {row['icet']['bytes'] / 1e6:.1f} |" if with_icet else ''))
    return lines


def stage_table(rows):
    lines = ['| processes | read ms | picture ms | draw ms | draw CPU ms, all | wait ms | composite ms | gather ms '
             '| warp ms | messages | MB |',
             '|' + '---|' * 11]
    for row in rows:
        lines.append(f"| {row['processes']} | {ms(row['read_s'])} | {ms(row['total_s'])} | " +
                     ' | '.join(ms(row[stage]) for stage in STAGES) +
                     f" | {row['messages']:.0f} | {row['bytes'] / 1e6:.2f} |")
    return lines


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument('--build', default=os.path.join(ROOT, 'build'))
    options.add_argument('--launcher', default='mpirun')
    options.add_argument('--ranks', default='1,2,3,4,8,16')
    options.add_argument('--size', default='1024x768')
    options.add_argument('--repeats', type=int, default=15)
    options.add_argument('--rounds', type=int, default=3)
    options.add_argument('--volume', default=os.path.join(ROOT, 'samples', 'ch2better.nii.gz'))
    options.add_argument('--out', default=os.path.join(RESULTS, 'mpi.md'))
    a = options.parse_args()
    ranks = [int(word) for word in a.ranks.split(',')]
    prepare_environment()
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, 'volume.cvol')
        run([os.path.join(a.build, 'cvol'), 'compress', a.volume, path])
        grid = run_json([os.path.join(a.build, 'cvol'), 'info', path, '--json'])
        composites, renders = {n: [] for n in ranks}, {n: [] for n in ranks}
        for _ in range(a.rounds):
            for n in ranks:
                composites[n].append(composite(a, n))
                renders[n].append(render(a, n, path, folder))
    composites = [least_disturbed(composites[n]) for n in ranks]
    renders = [typical_picture(n, renders[n]) for n in ranks]
    text = [f'# Pictures of {a.size} by several processes', '',
            f'Made by `bench/mpi_speed.py` on {machine()}. Compositing: least / median of {a.repeats}.', '',
            *compositing_table(composites), '',
            f'Stages of cvol-mpi render, {os.path.basename(a.volume)}, one thread each: each '
            'stage of the slowest process, median of six pictures.', '', *stage_table(renders)]
    os.makedirs(os.path.dirname(os.path.abspath(a.out)), exist_ok=True)
    with open(a.out, 'w', encoding='utf-8') as file:
        file.write('\n'.join(text) + '\n')
    with open(os.path.splitext(a.out)[0] + '.json', 'w', encoding='utf-8') as file:
        json.dump({'machine': machine(), 'cores': len(os.sched_getaffinity(0)), 'size': a.size,
                   'dims': grid['dims'], 'compositing': composites, 'stages': renders}, file, indent=1)
    print('\n'.join(text))


if __name__ == '__main__':
    main()
