"""Replays the measured times of the cells of a study on many ranks.

    python3 docs/cluster/replay.py results/parts [copies]

Reads the seconds of all cells from the journals of a folder, repeats them `copies` times with times
drawn anew from the measured ones, and prints the share of the ranks' time that is spent on cells,
for three ways of dealing them out: round-robin in the order of the plan, round-robin in the order of
falling cost, and one by one to the rank that is free first (`afterbay-mpi`; rank 0 does not count).
"""

import glob
import heapq
import json
import random
import sys


def measured(folder):
    """The seconds of each cell, in the order of the journals."""
    seconds = []
    for name in sorted(glob.glob(folder + "/*.jsonl")):
        with open(name) as lines:
            next(lines)
            seconds += [json.loads(line)["seconds"] for line in lines]
    return seconds


def dealt(times, ranks):
    """The time until the last rank ends, cells dealt out round-robin."""
    return max(sum(times[rank::ranks]) for rank in range(ranks))


def on_demand(times, ranks):
    """The same, each cell given to the rank that is free first."""
    free = [0.0] * ranks
    for time in times:
        heapq.heapreplace(free, free[0] + time)
    return max(free)


def main():
    seconds = measured(sys.argv[1])
    copies = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    random.seed(1)
    times = seconds if copies == 1 else random.choices(seconds, k=copies * len(seconds))
    total, falling = sum(times), sorted(times, reverse=True)
    print(f"{len(times)} cells, {total:.1f} s, the longest {falling[0]:.3f} s")
    print(f"{'ranks':>6} {'as planned':>12} {'by cost':>12} {'one by one':>12}")
    for ranks in (2, 64, 1000, 10000):
        spans = dealt(times, ranks), dealt(falling, ranks), on_demand(falling, ranks)
        shares = " ".join(f"{100 * total / (ranks * span):11.1f}%" for span in spans)
        print(f"{ranks:>6} {shares}")


main()
