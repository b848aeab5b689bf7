#!/usr/bin/python3
"""A model of pictures by many processes, from the stages that bench/mpi_speed.py measured.

    bench/mpi_model.py [--measured bench/results/mpi.json] [--volume 10240x7680x1536] [--size 4096x1024]
                       [--latency-us 5] [--bandwidth-gb 11] [--processes 1,2,4,...,4096]

It predicts this computer's own times first, with the cost of processes that share cores, and prints the error of each
prediction; then pictures on a cluster with one process a node.

Costs come from runs of one and two processes, which have a core each: seconds to scan a pixel of the image, to read,
merge and write a pixel that shows something, to draw and to warp. The cost of a switch between processes that share a
core, and half of the growth of drawing, come from three processes. The times of more are predictions; only the
imbalance comes from the most processes measured.

    shown(p)     pixels that p parts show = a (1 + b (p^(1/3) - 1)), fitted: parts of halves overlap in the picture
    round i      factor k, after groups of g: a process sends (k - 1)/k of shown(p/g)/p pixels of 16 bytes in k - 1
                 messages, and merges as many as it had
    collective   four agreements of 2 log2(p) latencies, one with 8 bytes for each line of the image
    gather       process 0 receives the picture, in p - 1 messages
    drawing      work (1 + growth (p^(1/3) - 1)) / p (1 + imbalance log2(p)); grows with the pixels of the picture, and
                 with the mean side of the volume at the level that is drawn, where a pixel is at most two samples

Default network: 11 GB/s, a port of 100 Gbit/s (InfiniBand EDR, HDR100) less its overhead; 5 microseconds, which Red
Storm required between its furthest nodes (Brightwell et al., "Portals 3.3 on the Sandia/Cray Red Storm System");
networks of today are faster. The model has no congestion. Here, more processes than cores share the cores evenly, also
those that wait, because they poll.
"""
import argparse
import json
import math
import os
import sys

from tables import RESULTS

BYTES = 16  # of a pixel
MOST_K = 8
AGREEMENTS = 4


def rounds_of(processes):
    """Returns members and factors (mpi/radix_k.c)."""
    for members in range(processes, 0, -1):
        factors, left = [], members
        while left > 1:
            k = next((k for k in range(MOST_K, 1, -1) if left % k == 0), 0)
            if not k:
                break
            factors.append(k)
            left //= k
        if left == 1:
            return members, factors
    raise ValueError(f'{processes} processes')


def fit_overlap(rows):
    """Returns a and b of shown(p): a from one process, b by least squares."""
    a = rows[0]['shown']
    x = [row['processes'] ** (1 / 3) - 1 for row in rows]
    y = [row['shown'] / a - 1 for row in rows]
    return a, sum(p * q for p, q in zip(x, y)) / sum(p * p for p in x)


class Work:
    """What the processes do in one picture, in pixels and messages; without times."""

    def __init__(self, processes, pixels, lines, shown, overlap):
        members, factors = rounds_of(processes)

        def all_shown(groups):
            return shown * (1 + overlap * (groups ** (1 / 3) - 1))
        self.processes, self.pixels, self.lines = processes, pixels, lines
        self.read = all_shown(processes) / processes
        self.merged = self.sent = 0.0
        self.messages = 0
        group, self.rounds = 1, len(factors)
        folded = processes - members
        if folded:  # one more message, of one fragment, for the slowest process
            self.sent, self.merged, self.messages = self.read, 2 * self.read, 1
        self.all_sent, self.all_messages = folded * self.read, folded
        for k in factors:
            fragment = all_shown(members / group) / members
            self.merged += fragment
            self.sent += fragment * (k - 1) / k
            self.messages += k - 1
            self.all_sent += members * fragment * (k - 1) / k
            self.all_messages += members * (k - 1)
            group *= k
        self.gathered = shown * (1 - 1 / members)
        self.gather_messages = members - 1
        self.written = shown
        self.all_sent += self.gathered
        self.all_messages += self.gather_messages


def work_of(row, overlap):
    return Work(row['processes'], row['width'] * row['height'], row['height'], overlap[0], overlap[1])


def fit_costs(rows, overlap):
    """Returns seconds: of a pixel to scan, read, merge and write, and of a switch between processes."""
    one, two, three = (next(row for row in rows if row['processes'] == p) for p in (1, 2, 3))

    def seconds(row, stage):
        return row['radix_k'][stage]['min']
    scan = (seconds(one, 'total_s') - seconds(one, 'composite_s') - seconds(one, 'gather_s')) / \
        (one['width'] * one['height'])
    costs = {'scan': max(scan, 0), 'read': seconds(one, 'composite_s') / one['shown'],
             'write': seconds(one, 'gather_s') / one['shown'], 'switch': 0.0, 'merge': 0.0}
    work = work_of(two, overlap)
    costs['merge'] = max(seconds(two, 'total_s') - predict_here(work, costs, 2), 0) / work.merged
    rest = seconds(three, 'total_s') - predict_here(work_of(three, overlap), costs, 2)
    costs['switch'] = max(rest, 0) / waits(work_of(three, overlap))
    return costs


def waits(work):
    """Waits of all processes together: in agreements, at the ends of rounds, and for the gather."""
    steps = AGREEMENTS * math.ceil(math.log2(max(work.processes, 2)))
    return work.processes * (steps + work.rounds + 1)


def predict_here(work, costs, cores):
    """Seconds of compositing on this computer: messages are copies, which the cost of merging has. Processes that share
    cores take turns, because all wait for the last; and there is a switch for each wait."""
    each = work.pixels * costs['scan'] + work.read * costs['read'] + work.merged * costs['merge']
    together = each * math.ceil(work.processes / cores) + work.written * costs['write']
    return together + (waits(work) * costs['switch'] if work.processes > cores else 0)


def predict_cluster(work, costs, latency, bandwidth):
    """Seconds of compositing and of the gather, one process a node."""
    agreements = AGREEMENTS * 2 * math.ceil(math.log2(work.processes)) * latency + 2 * 8 * work.lines / bandwidth
    if work.processes == 1:
        agreements = 0
    composite = agreements + work.pixels * costs['scan'] + work.read * costs['read'] + \
        work.merged * costs['merge'] + work.messages * latency + BYTES * work.sent / bandwidth
    gather = work.gather_messages * latency + BYTES * work.gathered / bandwidth + work.written * costs['write']
    return composite, gather


def fit_drawing(stages):
    """Returns the work of one process, its growth with the surfaces of the parts, their imbalance, and the warp.

    From processor times, which other programs disturb less. All processes together work (1 + growth (p^(1/3) - 1))
    times as long as one: rays do not end where another part hides the rest, and parts have margins.
    """
    rows = {row['processes']: row for row in stages}
    one, largest = rows[1]['all_cpu_s'], stages[-1]
    growth = sum((rows[p]['all_cpu_s'] / one - 1) / (p ** (1 / 3) - 1) for p in (2, 3)) / 2
    uneven = largest['processes'] * largest['draw_cpu_s'] / largest['all_cpu_s']
    return {'work': one, 'growth': max(growth, 0), 'warp': rows[1]['warp_s'],
            'imbalance': (uneven - 1) / math.log2(largest['processes'])}


def slowest_drawing(drawing, processes):
    """Seconds of processor time of the busiest process."""
    together = drawing['work'] * (1 + drawing['growth'] * (processes ** (1 / 3) - 1))
    return together / processes * (1 + drawing['imbalance'] * math.log2(processes))


def mean_side(dims):
    return math.prod(dims) ** (1 / 3)


def numbers(text):
    try:
        values = [int(word) for word in text.replace(',', 'x').split('x')]
    except ValueError:
        values = []
    if not values or min(values) < 1:
        sys.exit(f"'{text}': give whole numbers from 1")
    return values


def check_here(measured, overlap, costs, drawing):
    """Returns the lines of the tables that compare predictions with measurements."""
    cores = measured['cores']
    lines = [f'Compositing here, {cores} cores, radix-k. Fitted to 1, 2 and 3 processes.', '',
             '| processes | MB measured | MB model | error | ms measured | ms model | error |',
             '|---|---|---|---|---|---|---|']
    for row in measured['compositing']:
        work, ours = work_of(row, overlap), row['radix_k']
        seconds, total = predict_here(work, costs, cores), ours['total_s']['min']
        size = BYTES * work.all_sent
        error = f"{100 * (size / ours['bytes'] - 1):+.0f} %" if ours['bytes'] else '-'
        lines.append(f"| {row['processes']} | {ours['bytes'] / 1e6:.1f} | {size / 1e6:.1f} | {error} | "
                     f"{1e3 * total:.1f} | {1e3 * seconds:.1f} | {100 * (seconds / total - 1):+.0f} % |")
    lines += ['', 'Pictures of cvol-mpi render here. Drawing is fitted to processor times of 1, 2 and 3 processes.', '',
              '| processes | ms measured | ms model | error |', '|---|---|---|---|']
    for row in measured['stages']:
        p = row['processes']
        work = Work(p, *render_pixels(measured), overlap[1])
        seconds = slowest_drawing(drawing, p) * max(1, p / cores) + predict_here(work, costs, cores) + \
            drawing['warp']
        lines.append(f"| {p} | {1e3 * row['total_s']:.0f} | {1e3 * seconds:.0f} | "
                     f"{100 * (seconds / row['total_s'] - 1):+.0f} % |")
    return lines


def render_pixels(measured):
    """Pixels, lines, and pixels that show something, of the pictures of the second table: all of them, at most."""
    width, height = numbers(measured['size'])
    return width * height, height, width * height


def predict(measured, a, overlap, costs, drawing):
    width, height = numbers(a.size)
    dims = numbers(a.volume)
    level = 0
    while max(dims) / 2 ** level >= 2 * max(width, height):
        level += 1
    old = numbers(measured['size'])
    share = width * height / (old[0] * old[1])
    depth = mean_side([n / 2 ** level for n in dims]) / mean_side(measured['dims'])
    warp = share * drawing['warp']
    lines = [f'A cluster: volume {a.volume}, level {level}, picture {a.size}, one thread a process, one process a '
             f'node, {a.latency_us:g} us, {a.bandwidth_gb:g} GB/s.', '',
             '| processes | draw ms | composite ms | gather ms | warp ms | frames/s | messages | MB |',
             '|' + '---|' * 8]
    for p in numbers(a.processes):
        work = Work(p, width * height, height, width * height, overlap[1])
        composite, gather = predict_cluster(work, costs, 1e-6 * a.latency_us, 1e9 * a.bandwidth_gb)
        draw = share * depth * slowest_drawing(drawing, p)
        total = draw + composite + gather + warp
        lines.append(f'| {p} | {1e3 * draw:.0f} | {1e3 * composite:.1f} | {1e3 * gather:.1f} | '
                     f'{1e3 * warp:.1f} | {1 / total:.3g} | {work.all_messages} | '
                     f'{BYTES * work.all_sent / 1e6:.0f} |')
    return lines


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument('--measured', default=os.path.join(RESULTS, 'mpi.json'))
    options.add_argument('--volume', default='10240x7680x1536')
    options.add_argument('--size', default='4096x1024')
    options.add_argument('--latency-us', type=float, default=5)
    options.add_argument('--bandwidth-gb', type=float, default=11)
    options.add_argument('--processes', default='1,2,4,8,16,32,64,128,256,512,1024,2048,4096')
    a = options.parse_args()
    try:
        with open(a.measured, encoding='utf-8') as file:
            measured = json.load(file)
    except OSError as error:
        sys.exit(f'{a.measured}: {error.strerror}; run bench/mpi_speed.py first')
    overlap = fit_overlap(measured['compositing'])
    costs = fit_costs(measured['compositing'], overlap)
    drawing = fit_drawing(measured['stages'])
    print(f"Costs: scan {1e9 * costs['scan']:.2f}, read {1e9 * costs['read']:.2f}, merge {1e9 * costs['merge']:.2f}, "
          f"write {1e9 * costs['write']:.2f} ns a pixel; {1e6 * costs['switch']:.1f} us a switch; overlap "
          f"{overlap[1]:.2f}; drawing {1e3 * drawing['work']:.0f} ms, growth {drawing['growth']:.2f}, "
          f"imbalance {drawing['imbalance']:.3f}.\n")
    print('\n'.join(check_here(measured, overlap, costs, drawing)))
    print()
    print('\n'.join(predict(measured, a, overlap, costs, drawing)))


if __name__ == '__main__':
    main()
