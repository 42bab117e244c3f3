"""Read an output file of `contensou cost` and draw error against CPU time."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import h5py
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter

from . import style
from .results import ResultError

FILETYPE = "contensou-cost"

# Line and marker of each method.
METHODS = {
    "cvode_bdf": ("-", "o"),
    "cvode_adams": ("--", "s"),
    "explicit8": ("-.", "^"),
    "auto": (":", "D"),
}


@dataclass(frozen=True)
class Study:
    """What is drawn of a file; arrays over its runs unless a name says otherwise."""

    title: str
    version: str
    measure: str
    model_names: list[str]
    model_error: np.ndarray
    agreement: float
    model: np.ndarray
    method: np.ndarray
    rtol: np.ndarray
    cpu: np.ndarray
    numerical: np.ndarray
    error: np.ndarray
    bound: np.ndarray
    pareto: np.ndarray
    done: np.ndarray


def is_study(path: Path) -> bool:
    """Whether a file is one of `contensou cost`."""
    try:
        with h5py.File(path) as file:
            return text(file.attrs.get("filetype", "")) == FILETYPE
    except OSError:
        return False


def text(value: object) -> str:
    """A text of HDF5, whatever its kind."""
    return value.decode() if isinstance(value, bytes) else str(value)


def read(path: Path) -> Study:
    """The study in a file."""
    with h5py.File(path) as file:
        runs = file["run"]
        column = {name: runs[name][()] for name in runs if name != "label"}
        names = [text(name).strip() for name in file["model/name"][()]]
        words = {
            name: np.array([text(value).strip() for value in column[name]])
            for name in ("model", "method", "status")
        }
        if not len(column["cpu"]):
            raise ResultError(f"{path} holds no runs")
        return Study(
            title=text(file.attrs["title"]) or path.stem,
            version=text(file.attrs["program_version"]),
            measure=text(file.attrs["measure"]),
            model_names=names,
            model_error=file["model/error"][()],
            agreement=float(file["model/agreement"][0]),
            model=words["model"],
            method=words["method"],
            rtol=column["rtol"],
            cpu=column["cpu"],
            numerical=column["error_numerical"],
            error=column["error"],
            bound=column["error_bound"],
            pareto=column["pareto"] > 0,
            done=words["status"] == "done",
        )


def colour_of(study: Study, model: str) -> str:
    """Colour of a model: that of its friction where it has one."""
    nth = study.model_names.index(model) % len(style.CYCLE)
    return style.colour_of(model, style.CYCLE[nth])


def draw_lines(axes: Axes, study: Study, values: np.ndarray) -> None:
    """One line for each model and method, through its tolerances."""
    for model in study.model_names:
        for method, (line, marker) in METHODS.items():
            where = (study.model == model) & (study.method == method) & study.done
            where &= np.isfinite(values) & (values > 0)
            order = np.argsort(-study.rtol[where])
            axes.plot(
                study.cpu[where][order],
                values[where][order],
                linestyle=line,
                marker=marker,
                markersize=4,
                linewidth=1.1,
                color=colour_of(study, model),
                zorder=3,
            )
    if np.isfinite(study.agreement) and study.agreement > 0:
        axes.axhspan(axes.get_ylim()[0] * 1e-9, study.agreement, color=style.LIGHT, zorder=0)
    style.log_scale(axes.xaxis)
    style.log_scale(axes.yaxis)
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("CPU time [s]")


def limits(study: Study) -> tuple[float, float]:
    """Common range of the errors."""
    shown = np.concatenate([study.numerical, study.error, study.model_error])
    shown = shown[np.isfinite(shown) & (shown > 0)]
    if not len(shown):
        raise ResultError("no run of this study has an error that is known")
    return 10 ** np.floor(np.log10(shown.min()) - 0.1), 10 ** np.ceil(np.log10(shown.max()) + 0.1)


def draw(path: Path) -> Figure:
    """The whole picture: numerical error beside the error against the exact model."""
    style.apply()
    study = read(path)
    figure, (left, right) = plt.subplots(1, 2, sharey=True, figsize=(11, 5.6))
    figure.subplots_adjust(left=0.075, right=0.795, top=0.82, bottom=0.1, wspace=0.08)
    style.headline(
        figure,
        study.title,
        f"contensou {study.version}  ·  error: {study.measure} of the trajectory, scaled",
    )
    low, high = limits(study)
    left.set_ylim(low, high)
    draw_lines(left, study, study.numerical)
    left.set_title("Numerical error: against the same model")
    left.set_ylabel("scaled error")
    draw_lines(right, study, study.error)
    right.set_title("Error: against the exact model")
    for name, error in zip(study.model_names[1:], study.model_error[1:], strict=True):
        if np.isfinite(error) and error > 0:
            right.axhline(error, color=colour_of(study, name), linewidth=0.8, zorder=1)
    front = np.flatnonzero(study.pareto)
    front = front[np.argsort(study.cpu[front])]
    right.plot(
        study.cpu[front],
        study.bound[front],
        "o",
        markersize=10,
        markerfacecolor="none",
        markeredgecolor=style.DARK,
        zorder=4,
    )
    left.set_ylim(low, high)
    key = [
        Line2D([], [], color=colour_of(study, name), linewidth=2, label=name)
        for name in study.model_names
        if name in study.model or name == study.model_names[0]
    ]
    key += [
        Line2D([], [], color=style.DARK, linestyle=line, marker=mark, markersize=4, label=method)
        for method, (line, mark) in METHODS.items()
        if method in study.method
    ]
    key += [
        Line2D([], [], color=style.GREY, linewidth=0.8, label="error of the model"),
        Line2D(
            [],
            [],
            color=style.DARK,
            linestyle="",
            marker="o",
            markersize=9,
            markerfacecolor="none",
            label="Pareto front",
        ),
        Line2D([], [], color=style.LIGHT, linewidth=8, label="not resolved by\nthe references"),
    ]
    figure.legend(handles=key, loc="upper left", bbox_to_anchor=(0.8, 0.83))
    return figure
