"""Replays the measured times of the cells of a study on many ranks.

    python3 docs/cluster/replay.py results/parts [copies] [figure.svg]

Reads the seconds of all cells from the journals of a folder, repeats them `copies` times with times
drawn anew from the measured ones, and prints the share of the ranks' time that is spent on cells,
for three ways of dealing them out: round-robin in the order of the plan, round-robin in the order of
falling cost, and one by one to the rank that is free first (`afterbay-mpi`; rank 0 does not count).
The figure shows them for all powers of two, and needs Matplotlib.
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


def efficiencies(times, ranks):
    """The share of the ranks' time that is spent on cells, for the three ways."""
    falling = sorted(times, reverse=True)
    spans = dealt(times, ranks), dealt(falling, ranks), on_demand(falling, ranks)
    return [sum(times) / (ranks * span) for span in spans]


def draw(times, path):
    """Draws the efficiencies over the number of ranks."""
    import matplotlib.pyplot as plt

    plt.rcParams["svg.hashsalt"] = "afterbay"
    ranks = [2**k for k in range(1, 15)]
    ways = zip(*(efficiencies(times, n) for n in ranks))
    styles = [
        ("round-robin as planned", "#D55E00", "o"),
        ("round-robin by falling time", "#0072B2", "s"),
        ("one by one", "#009E73", "^"),
    ]
    figure, axes = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
    for (label, colour, mark), shares in zip(styles, ways):
        axes.plot(ranks, [100 * share for share in shares], color=colour, marker=mark, label=label)
    axes.set(xscale="log", ylim=(0, 104), xlabel="ranks", ylabel="time spent on cells (%)")
    axes.set_title(f"{len(times):,} cells, {sum(times):.0f} s of work, simulated", fontsize=11)
    axes.grid(alpha=0.3)
    axes.legend(frameon=False, loc="lower left")
    figure.savefig(path, metadata={"Date": None})


def main():
    seconds = measured(sys.argv[1])
    copies = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    random.seed(1)
    times = seconds if copies == 1 else random.choices(seconds, k=copies * len(seconds))
    print(f"{len(times)} cells, {sum(times):.1f} s, the longest {max(times):.3f} s")
    print(f"{'ranks':>6} {'as planned':>12} {'by cost':>12} {'one by one':>12}")
    for ranks in (2, 64, 1000, 10000):
        shares = " ".join(f"{100 * share:11.1f}%" for share in efficiencies(times, ranks))
        print(f"{ranks:>6} {shares}")
    if len(sys.argv) > 3:
        draw(times, sys.argv[3])


main()
