"""The chart of error and jitter over time, for both methods."""
import matplotlib
import numpy as np

matplotlib.use('Agg')
from matplotlib import pyplot  # after the choice of the backend

COLORS = {"the course's code": 'tab:orange', 'unit5': 'tab:blue'}


def jitter(corners):
    """(n,) pixels: the largest second difference among the four corners, (n, 4, 2); NaN without an area."""
    change = np.full(len(corners), np.nan)
    change[2:] = np.linalg.norm(np.diff(corners, 2, axis=0), axis=2).max(axis=1)
    return change


def draw(path, title, stamps, course, ours, truth=None):
    """Write the chart as a PNG. Without the truth it shows only the jitter."""
    both = dict(zip(COLORS, (course, ours)))
    rows = {'jitter (px)': jitter}
    if truth is not None:
        rows = {'error (px)': lambda corners: np.linalg.norm(corners - truth, axis=2).max(axis=1), **rows}
    figure, axes = pyplot.subplots(len(rows) + 1, 1, sharex=True, figsize=(11, 2.4 * len(rows) + 1.4),
                                   squeeze=False,
                                   gridspec_kw={'height_ratios': [3] * len(rows) + [1]})
    axes = axes[:, 0]
    for axis, (label, measure) in zip(axes, rows.items()):
        for name, corners in both.items():
            axis.plot(stamps, measure(corners), '.-', color=COLORS[name], label=name, markersize=3,
                      linewidth=0.8)
        axis.set_ylabel(label)
        axis.set_ylim(bottom=0)
        axis.grid(alpha=0.3)
    axes[0].set_title(title)
    axes[0].legend(loc='upper right')
    for level, (name, corners) in enumerate(both.items()):
        found = ~np.isnan(corners[:, 0, 0])
        axes[-1].scatter(stamps[found], np.full(found.sum(), -level), marker='|', color=COLORS[name])
    axes[-1].set_yticks([0, -1])
    axes[-1].set_yticklabels(['course', 'unit5'])
    axes[-1].set_ylim(-1.6, 0.6)
    axes[-1].set_ylabel('has an area')
    axes[-1].set_xlabel('seconds')
    figure.tight_layout()
    figure.savefig(path, dpi=80)
    pyplot.close(figure)
