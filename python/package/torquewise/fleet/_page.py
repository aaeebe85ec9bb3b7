"""The table and the page of a fleet."""

from __future__ import annotations

import csv
import datetime
import html as escaped
import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from ._drift import PARAMETERS, Reading

if TYPE_CHECKING:
    from . import Fleet

_UNITS = ("N·m·s/rad", "N·m", "part", "N·m")


def table(fleet: Fleet) -> Any:
    """A row for each log, joint and parameter."""
    import pyarrow as pa

    columns: dict[str, list[Any]] = {
        key: []
        for key in ("robot", "time", "file", "joint", "parameter", "unit", "change", "std_error")
    }
    for robot, logs in fleet.readings.items():
        for when, own in logs:
            if own.reason is not None:
                continue
            for joint, name in enumerate(fleet.model.joints):
                for k, parameter in enumerate(PARAMETERS):
                    words = [str(robot), str(when), own.path, name, parameter, _UNITS[k]]
                    numbers = [float(own.values[joint, k]), float(own.errors[joint, k])]
                    for column, value in zip(columns.values(), [*words, *numbers]):
                        column.append(value)
    return pa.table(columns)


def save(fleet: Fleet, folder: Any) -> None:
    """Everything that was found, each file whole or not at all."""
    folder = Path(folder)
    (folder / "models").mkdir(parents=True, exist_ok=True)
    fleet.model.save(folder / "model.json")
    for robot, model in fleet.models.items():
        model.save(folder / "models" / f"{_plain(robot)}.json")
    text = io.StringIO()
    rows = csv.writer(text)
    rows.writerow(["file", "rows", "checksum", "reason"])
    rows.writerows(
        [own.path, own.rows, own.checksum or "", own.reason or ""] for own in fleet.files
    )
    _core.write_whole(folder / "files.csv", text.getvalue().encode())
    if fleet.readings:
        import pyarrow.parquet as pq

        sink = io.BytesIO()
        pq.write_table(table(fleet), sink)
        _core.write_whole(folder / "drift.parquet", sink.getvalue())
    _core.write_whole(folder / "fleet.html", html(fleet).encode())


def _plain(name: Any) -> str:
    return "".join(own if own.isalnum() or own in "-_." else "_" for own in str(name)) or "_"


def html(fleet: Fleet) -> str:
    """One page that needs no network."""
    good = len(fleet.files) - len(fleet.bad)
    parts = [
        f"<p class=lead>{len(fleet.models) or 1} robots, {fleet.rows:,} rows in {good} files, "
        f"{len(fleet.bad)} left out. The model of all is <b>{_text(fleet.verdict)}</b>."
        f" {_text('; '.join(fleet.because))}</p>",
        _made(fleet),
        "<h2>What changed</h2>",
        _changes(fleet),
    ]
    if fleet.readings:
        parts += ["<h2>Robots</h2>", _robots(fleet)]
    if fleet.bad:
        rows = "".join(f"<tr><td>{_text(o.path)}<td>{_text(o.reason)}" for o in fleet.bad)
        parts += ["<h2>Files left out</h2>", f"<table><tr><th>file<th>why{rows}</table>"]
    return _FRAME.replace("{body}", "\n".join(parts))


def _made(fleet: Fleet) -> str:
    """When the page was made, by what, and with which options."""
    asked = ", ".join(f"{key}={own!r}" for key, own in sorted(fleet.plan.options.items()))
    made = f"torquewise {_core.__version__}, {datetime.date.today():%Y-%m-%d}"
    return f"<p>Made by {made}, with {_text(asked) or 'the usual options'}.</p>"


def _changes(fleet: Fleet) -> str:
    if not fleet.readings:
        return "<p>Not looked for: robots were not told apart.</p>"
    if not fleet.changes:
        return "<p>Nothing that is not chance.</p>"
    rows = []
    for own in fleet.changes:
        joint, k = fleet.model.joints.index(own.joint), PARAMETERS.index(own.parameter)
        told = _told(fleet, own.robot)
        points = [(float(it.values[joint, k]), float(it.errors[joint, k])) for _, it in told]
        ends = f"{_text(told[0][0])} … {_text(told[-1][0])}"
        chart = f"{_chart(points)}<br><small>{ends}</small>"
        percent = "" if own.percent is None else f" ({own.percent:+.0f} %)"
        rows.append(
            f"<tr><td>{_text(own.robot)}<td>{_text(own.joint)}<td>{own.parameter}"
            f"<td>{own.change:+.3g} ± {own.error:.1g} {_UNITS[k]}{percent}<td>{_text(own.when)}"
            f"<td>{own.chance:.1e}<td>{chart}"
        )
    head = "<tr><th>robot<th>joint<th>parameter<th>change<th>since<th>by chance<th>logs"
    return f"<table>{head}{''.join(rows)}</table>"


def _told(fleet: Fleet, robot: Any) -> list[tuple[Any, Reading]]:
    return [(when, own) for when, own in fleet.readings[robot] if own.reason is None]


def _robots(fleet: Fleet) -> str:
    names = "".join(f"<th>{_text(own)}" for own in fleet.model.joints)
    rows = []
    changed = {own.robot for own in fleet.changes}
    for robot in sorted(fleet.readings, key=str):
        told = _told(fleet, robot)
        left = np.mean([own.rms for _, own in told], axis=0) if told else []
        cells = "".join(f"<td>{own:.3g}" for own in left)
        mark = " class=changed" if robot in changed else ""
        rows.append(f"<tr{mark}><td>{_text(robot)}<td>{len(told)}{cells}")
    head = f"<tr><th>robot<th>logs{names}"
    return f"<p>RMS of what the model of each robot leaves of its torque [N·m].</p><table>{head}{''.join(rows)}</table>"


def _chart(points: list[tuple[float, float]], width: int = 220, height: int = 36) -> str:
    """Values with their errors over the logs."""
    told = [(k, value, error) for k, (value, error) in enumerate(points) if np.isfinite(error)]
    if not told:
        return ""
    low, high = min(v - e for _, v, e in told), max(v + e for _, v, e in told)
    span, count = max(high - low, 1e-300), max(len(points) - 1, 1)
    marks = []
    for k, value, error in told:
        x = 3 + (width - 6) * k / count
        up, down, middle = (
            3 + (height - 6) * (high - y) / span for y in (value + error, value - error, value)
        )
        marks.append(
            f'<path d="M{x:.1f} {up:.1f}V{down:.1f}"/><circle cx="{x:.1f}" cy="{middle:.1f}" r="1.8"/>'
        )
    return f'<svg width="{width}" height="{height}">{"".join(marks)}</svg>'


def _text(own: Any) -> str:
    return escaped.escape(str(own))


_FRAME = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>Fleet</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; max-width: 68rem; margin: 2rem auto; padding: 0 1rem; color: #222 }
.lead { font-size: 1.1rem }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; display: block; overflow-x: auto }
th, td { text-align: left; padding: .2rem .8rem .2rem 0; border-bottom: 1px solid #ddd; vertical-align: middle }
.changed td { background: #fff3e0 }
svg path { stroke: #9ab } svg circle { fill: #4c78a8 }
</style></head><body>
<h1>Fleet</h1>
{body}
</body></html>
"""
