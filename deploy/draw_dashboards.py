"""Draws dashboards from the numbers that Grafana would get, one picture each."""

import math

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

COLUMNS = 24


def draw(answers, folder):
    folder.mkdir(parents=True, exist_ok=True)
    for name, (board, panels) in answers.items():
        rows = max(panel["gridPos"]["y"] + panel["gridPos"]["h"] for panel in board["panels"])
        figure = plt.figure(figsize=(20, 0.55 * rows), layout="constrained")
        grid = figure.add_gridspec(rows, COLUMNS)
        for panel in board["panels"]:
            at = panel["gridPos"]
            axes = figure.add_subplot(grid[at["y"] : at["y"] + at["h"], at["x"] : at["x"] + at["w"]])
            draw_panel(axes, panel, panels[panel["id"]])
        figure.suptitle(board["title"])
        figure.savefig(folder / f"{name}.png", dpi=70)
        plt.close(figure)


def draw_panel(axes, panel, series):
    unit = panel["fieldConfig"]["defaults"]["unit"]
    axes.set_title(f"{panel['title']} [{unit}]", fontsize=9)
    axes.tick_params(labelsize=7)
    kind = panel["type"]
    if kind in ("stat", "gauge"):
        return words(axes, panel, series)
    if kind == "piechart":
        return axes.pie([points[-1][1] for points in series.values()], labels=list(series))
    if kind == "heatmap":
        return heatmap(axes, series)
    return curves(axes, panel, series)


def words(axes, panel, series):
    axes.axis("off")
    by_name = panel["options"].get("textMode") == "name"
    text = "\n".join(name if by_name else f"{points[-1][1]:.4g}" for name, points in series.items())
    axes.text(0.5, 0.5, text, ha="center", va="center", fontsize=11)


def curves(axes, panel, series):
    custom = panel["fieldConfig"]["defaults"]["custom"]
    start = min(points[0][0] for points in series.values())
    if custom["stacking"]["mode"] == "normal":
        times = sorted({when for points in series.values() for when, _ in points})
        rows = [[dict(points).get(when, 0.0) for when in times] for points in series.values()]
        axes.stackplot([when - start for when in times], rows, labels=list(series), alpha=0.6)
    else:
        for name, points in series.items():
            axes.plot([when - start for when, _ in points], [value for _, value in points], label=name)
        if "scaleDistribution" in custom:
            axes.set_yscale("log", nonpositive="mask")
        else:
            axes.set_ylim(bottom=0)
    axes.legend(fontsize=6, loc="upper left")


def heatmap(axes, series):
    edge = lambda name: math.inf if name == "+Inf" else float(name)
    names = sorted(series, key=edge)
    times = sorted({when for points in series.values() for when, _ in points})
    rows = [[dict(series[name]).get(when, 0.0) for when in times] for name in names]
    # The buckets of Prometheus hold all below; a heatmap shows each by itself.
    own = [rows[0]] + [
        [max(high - low, 0.0) for low, high in zip(below, above)]
        for below, above in zip(rows, rows[1:])
    ]
    axes.imshow(own, aspect="auto", origin="lower", cmap="Oranges", interpolation="nearest")
    axes.set_yticks(range(len(names)), names, fontsize=5)
