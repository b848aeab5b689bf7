"""Rows of choices in which every pair of choices of two axes occurs at least once.

An axis is a name and its choices. A row has one choice of each axis. All pairs of n axes need far fewer rows than
all combinations. Rows are built one by one, each around a pair that no row has yet; every other axis takes the
choice that adds most new pairs. A seed decides between equals."""
import itertools
import random


def pairs_of(row):
    """Yields the pairs of a row of choice numbers: ((axis, choice), (axis, choice))."""
    return itertools.combinations(enumerate(row), 2)


def rows(axes, seed, allowed=lambda row: True):
    """Returns a list of rows, each a dict of axis name to choice, and the pairs that are left out because no tried
    row with them is allowed. `allowed` gets a complete dict."""
    names = list(axes)
    choices = [list(axes[name]) for name in names]
    if len(names) < 2 or not all(choices):
        raise ValueError("pairs need two axes, each with a choice")
    draw = random.Random(seed)

    def named(row):
        return {name: choices[a][row[a]] for a, name in enumerate(names)}

    missing = {((a, i), (b, j))
               for a, b in itertools.combinations(range(len(names)), 2)
               for i in range(len(choices[a])) for j in range(len(choices[b]))}
    made, left_out = [], []
    while missing:
        first = min(missing)
        row = None
        for attempt in range(50):
            row = _around(first, choices, missing, draw, at_random=attempt > 0)
            if allowed(named(row)):
                break
            row = None
        if row is None:
            (a, i), (b, j) = first
            left_out.append(((names[a], choices[a][i]), (names[b], choices[b][j])))
            missing.discard(first)
        else:
            made.append(named(row))
            missing.difference_update(pairs_of(row))
    return made, left_out


def _around(pair, choices, missing, draw, at_random):
    """Returns a row with the pair. With `random` the other axes ignore the missing pairs."""
    row = [None] * len(choices)
    for axis, choice in pair:
        row[axis] = choice
    rest = [a for a in range(len(choices)) if row[a] is None]
    draw.shuffle(rest)
    for a in rest:
        chosen = [(b, c) for b, c in enumerate(row) if c is not None]

        def gain(choice):
            here = (a, choice)
            return sum(tuple(sorted((here, other))) in missing for other in chosen)

        order = list(range(len(choices[a])))
        draw.shuffle(order)
        row[a] = order[0] if at_random else max(order, key=gain)
    return row
