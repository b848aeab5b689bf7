"""Every pair of choices is in a row of pairwise.rows(), or listed as left out."""
import itertools
import pairwise

AXES = {"type": ["u8", "i16", "f32", "f64"], "data": list("abcdefghij"), "goal": list(range(7)),
        "haste": [False, True], "one": ["only"]}


def check(seed, allowed=lambda row: True):
    made, left_out = pairwise.rows(AXES, seed, allowed)
    named = {frozenset(pair) for pair in left_out}
    assert all(map(allowed, made)), "a row is not allowed"
    have = {frozenset(pair) for row in made for pair in itertools.combinations(row.items(), 2)}
    for x, y in itertools.combinations(AXES, 2):
        for i, j in itertools.product(AXES[x], AXES[y]):
            pair = frozenset(((x, i), (y, j)))
            assert (pair in have) != (pair in named), f"seed {seed}: {sorted(map(str, pair))}"
    return made, left_out


for seed in range(20):
    made, left_out = check(seed)
    assert not left_out and 70 <= len(made) <= 110, (seed, len(made), left_out)
    assert made == check(seed)[0], "the same seed makes other rows"
    _, left_out = check(seed, lambda row: not (row["type"] == "u8" and row["data"] == "c"))
    assert left_out == [(("type", "u8"), ("data", "c"))], left_out
print("every pair of 20 seeds is in a row")
