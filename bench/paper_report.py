"""Evaluates the paper's measurements: fitted exponents, short tables, plots."""
import math
import os

from paper_volumes import LOOKS, SIGNAL
from tables import markdown, provenance, write_results

TILES = 'deferred'
RHO = '0.03333'
# Fixed values of the parameters that are not varied; the signal uses another N, which takes less time.
N_FIXED, F_FIXED, N_SIGNAL = 256, 15, 128
OVER = ('N', 'f', 'rho')
COLOURS = {'thin': 'tab:blue', 'semi': 'tab:green', 'opaque': 'tab:red', SIGNAL: 'tab:purple'}
STYLES = {'splat': ('black', '-'), TILES: ('tab:green', '-'), 'literal': ('tab:orange', '-'),
          'deferred, whole slices': ('tab:green', '--'),
          'literal, whole slices': ('tab:orange', '--'), 'sheet': ('tab:blue', '-')}


# ---- exponents ----------------------------------------------------------------------------------

def slope(points):
    """Returns slope and intercept of the line fitted to the logarithms of pairs."""
    xs, ys = [[math.log(float(p[i])) for p in points] for i in (0, 1)]
    mean = sum(xs) / len(xs), sum(ys) / len(ys)
    return (sum((x - mean[0]) * (y - mean[1]) for x, y in zip(xs, ys)) /
            sum((x - mean[0]) ** 2 for x in xs))


def line_of(rows, engine, look, over):
    """Returns the rows of an engine in which only `over` varies, in its order."""
    fixed = {'N': N_SIGNAL if look == SIGNAL else N_FIXED, 'f': F_FIXED, 'rho': RHO}
    if engine not in (TILES, 'sheet') and over == 'rho':
        fixed['N'] = 64  # the slow engines are measured there
    del fixed[over]
    found = [row for row in rows if row['engine'] == engine and row['look'] == look and
             all(str(row[key]) == str(value) for key, value in fixed.items()
                 if row[key] != '')]  # engine sheet has no rho
    return sorted(found, key=lambda row: float(row[over] or 0))


def fit(line, over, key):
    points = [(row[over], row[key]) for row in line if row.get(key)]
    return f'{slope(points):.2f}' if len({x for x, _ in points}) > 1 else ''


def exponents(rows):
    for over in OVER:
        for look in LOOKS + (SIGNAL,):
            line = line_of(rows, TILES, look, over)
            if len(line) < 2:
                continue
            yield {'as a power of': over, 'look': look,
                   'splat, time': fit(line, over, 'splat_ms'), 'deferred, time': fit(line, over, 'ms'),
                   'ratio': fit(line, over, 'ratio'), "the paper's ratio": fit(line, over, 'predicted'),
                   'splat, multiply-adds': fit(line, over, 'splat_multiply_adds'),
                   'deferred, multiply-adds': fit(line, over, 'multiply_adds')}


def exponents_of_others(rows):
    for engine in dict.fromkeys(row['engine'] for row in rows):
        for over in OVER:
            line = line_of(rows, engine, 'semi', over)
            found = fit(line, over, 'ms') if engine != TILES else ''
            if found:
                yield {'engine': engine, 'as a power of': over,
                       'from': f'{line[0][over]} to {line[-1][over]}', 'time': found,
                       'multiply-adds': fit(line, over, 'multiply_adds')}


# ---- tables -------------------------------------------------------------------------------------

def short_number(value):
    return '-' if value is None else f'{value:.0f}' if value >= 10 else f'{value:.1f}'


def summary(rows, key):
    """Ratios for deferred tiles: a row for each N, a column for each f, all looks."""
    sizes, footprints = ([*dict.fromkeys(row[key] for row in rows)] for key in ('N', 'f'))
    ratio = {(row['N'], row['f'], row['look']): row.get(key) for row in rows
             if row['engine'] == TILES and row['rho'] == RHO}
    for size in sizes:
        row = {'N': size}
        for f in footprints:
            found = [ratio.get((size, f, look)) for look in LOOKS + (SIGNAL,)]
            row[f'{f} x {f}'] = ' / '.join(map(short_number, found))
        yield row


def engines_side_by_side(rows):
    """Milliseconds and PSNR of all engines, semi-transparent, at the fixed footprint and ratio 30."""
    for size in dict.fromkeys(row['N'] for row in rows):
        line = {row['engine']: row for row in rows if row['N'] == size and row['look'] == 'semi' and
                row['f'] == F_FIXED and row['rho'] in (RHO, '')}
        if not line:
            continue
        found = {'N': size, 'splat': next(iter(line.values()))['splat_ms'],
                 'separable': line.get(TILES, {}).get('separable_ms', '')}
        for engine, row in line.items():
            found[engine] = f"{row['ms']} ({row['psnr_db']} dB)"
        yield found


# ---- plots --------------------------------------------------------------------------------------

NAMES = {'N': f'N (f = {F_FIXED}, rho = 1/30)',
         'f': f'f, footprint f x f (N = {N_FIXED}, signal {N_SIGNAL})',
         'rho': f'rho (N = {N_FIXED}, signal {N_SIGNAL}; f = {F_FIXED})'}


def plot_ratios(axis, rows, over):
    """Times of splat divided by those of deferred, and the paper's growth through the first point."""
    for look, colour in COLOURS.items():
        line = line_of(rows, TILES, look, over)
        xs = [float(row[over]) for row in line]
        axis.loglog(xs, [row['ratio'] for row in line], color=colour, marker='.', label=look)
        if look == 'semi' and line:
            scale = line[0]['ratio'] / line[0]['predicted']
            axis.loglog(xs, [scale * row['predicted'] for row in line], ':', color='grey',
                        label="the paper's growth")
    mark(axis, [float(row[over]) for row in line_of(rows, TILES, 'semi', over)])


def plot_engines(axis, rows, over, key, of_splat):
    """All engines, semi-transparent."""
    line = line_of(rows, TILES, 'semi', over)
    axis.loglog([float(row[over]) for row in line], [row[of_splat] for row in line], color='black',
                marker='.', label='splat')
    for engine, (colour, style) in STYLES.items():
        if over == 'rho' and engine != TILES:
            continue  # measured at another N
        points = [row for row in line_of(rows, engine, 'semi', over) if row.get(key) and row[over]]
        if points:
            axis.loglog([float(row[over]) for row in points], [row[key] for row in points], style,
                        color=colour, marker='.', label=engine)
    mark(axis, [float(row[over]) for row in line])


def mark(axis, xs):
    axis.set_xticks(xs, [f'{x:g}' for x in xs])
    axis.minorticks_off()
    low, high = axis.get_ylim()
    ticks = [t * 10**e for e in range(-1, 12) for t in (1, 2, 5) if low <= t * 10**e <= high]
    if len(ticks) < 8:
        axis.set_yticks(ticks, [f'{t:g}' for t in ticks])


def plot(rows, path):
    import matplotlib
    matplotlib.use('Agg')
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(3, 3, figsize=(11, 9.6))
    for column, over in enumerate(OVER):
        plot_ratios(axes[0][column], rows, over)
        plot_engines(axes[1][column], rows, over, 'ms', 'splat_ms')
        plot_engines(axes[2][column], rows, over, 'multiply_adds', 'splat_multiply_adds')
        axes[2][column].set_xlabel(NAMES[over])
        for line in axes:
            line[column].grid(alpha=0.3)
    for line, label in zip(axes, ('time of splat / time of deferred', 'ms a picture, one thread (semi)',
                                  'multiply-adds (semi)')):
        line[0].set_ylabel(label)
        line[0].legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(path, dpi=90)


# ---- report -------------------------------------------------------------------------------------

def table(rows):
    rows = list(rows)
    columns = list(dict.fromkeys(key for row in rows for key in row))
    return [markdown(columns, rows), ''] if rows else []


def write(arguments, rows, skipped, seconds):
    text = ['# Splatting on compressed transforms against splatting', '',
            'Processor time of splat over that of transform (tiles of 16, deferred, rho 1/30), one '
            'thread, thin / semi / opaque / signal:', ''] + table(summary(rows, 'ratio'))
    text += ['Processor time of the separable splatter over that of transform:', '']
    text += table(summary(rows, 'of_transforms'))
    text += [f'Milliseconds a picture and PSNR against splat, semi, footprint {F_FIXED}, rho 1/30:', '']
    text += table(engines_side_by_side(rows))
    text += [f'Fitted exponents (N = {N_FIXED}, of the signal {N_SIGNAL}, f = {F_FIXED}, rho = 1/30 '
             'where these are not varied):', ''] + table(exponents(rows))
    text += ['The other engines, semi:', ''] + table(exponents_of_others(rows))
    text += ['All of it:', ''] + table(rows)
    if skipped:
        text += [f'Skipped, for want of memory: N = {", ".join(map(str, skipped))}.', '']
    write_results(arguments.results, 'paper',
                  '\n'.join(text + [f'{seconds:.0f} s.  '] + provenance(arguments.cvol)), rows)
    plot(rows, os.path.join(arguments.results, 'paper.png'))
