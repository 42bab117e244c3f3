"""Contensou: rigid bodies that touch, Hertz contacts with Contensou-Erismann friction.

SI units throughout. A scene is the name of a file, its text, or a dictionary of its groups;
`contensou help` lists groups and keys.

    >>> import contensou
    >>> ball = {
    ...     "scene": {"gravity": (0, 0, -9.81), "t_end": 0.1},
    ...     "material": {"name": "steel", "young": 2.1e11, "poisson": 0.3},
    ...     "body": {"name": "ball", "mass": 0.0327, "inertia": [1.31e-6] * 3,
    ...              "position": (0, 0, 0.51)},
    ...     "surface": [
    ...         {"name": "skin", "body": "ball", "shape": "sphere", "radius": 0.01,
    ...          "material": "steel"},
    ...         {"name": "floor", "body": "ground", "shape": "plane", "material": "steel"},
    ...     ],
    ...     "contact": {"name": "ball_floor", "surfaces": ("skin", "floor")},
    ... }
    >>> run = contensou.run(ball, {"output.interval": 0.05})
    >>> run.position.sel(body="ball", xyz="z").values.round(6).tolist()
    [0.51, 0.497737, 0.46095]
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from contensou._drawing import Page as Page
    from contensou._drawing import plot as plot
    from contensou._drawing import view as view
    from contensou._errors import ContensouError as ContensouError
    from contensou._errors import FileError as FileError
    from contensou._errors import SceneError as SceneError
    from contensou._errors import SceneWarning as SceneWarning
    from contensou._errors import SimulationError as SimulationError
    from contensou._kernels import Elliptic as Elliptic
    from contensou._kernels import Friction as Friction
    from contensou._kernels import Hertz as Hertz
    from contensou._kernels import Slopes as Slopes
    from contensou._kernels import Steps as Steps
    from contensou._kernels import Stiffness as Stiffness
    from contensou._kernels import Tangential as Tangential
    from contensou._kernels import Wrench as Wrench
    from contensou._kernels import elliptic as elliptic
    from contensou._kernels import hertz as hertz
    from contensou._kernels import tangential_stiffness as tangential_stiffness
    from contensou._runs import run as run
    from contensou._runs import run_tree as run_tree
    from contensou._scenes import Expression as Expression
    from contensou._scenes import scene_text as scene_text
    from contensou._simulation import Body as Body
    from contensou._simulation import Event as Event
    from contensou._simulation import Load as Load
    from contensou._simulation import Parameter as Parameter
    from contensou._simulation import Quantity as Quantity
    from contensou._simulation import Simulation as Simulation
    from contensou._simulation import Snapshot as Snapshot
    from contensou._sweeps import sweep as sweep

# Where each name is, which is read when it is first used: the program starts without numpy.
_HOMES = {
    "Body": "_simulation",
    "ContensouError": "_errors",
    "Elliptic": "_kernels",
    "Event": "_simulation",
    "Expression": "_scenes",
    "FileError": "_errors",
    "Friction": "_kernels",
    "Hertz": "_kernels",
    "SceneError": "_errors",
    "SceneWarning": "_errors",
    "SimulationError": "_errors",
    "Load": "_simulation",
    "Page": "_drawing",
    "Parameter": "_simulation",
    "Quantity": "_simulation",
    "Simulation": "_simulation",
    "Snapshot": "_simulation",
    "Slopes": "_kernels",
    "Steps": "_kernels",
    "Stiffness": "_kernels",
    "Tangential": "_kernels",
    "Wrench": "_kernels",
    "elliptic": "_kernels",
    "hertz": "_kernels",
    "plot": "_drawing",
    "run": "_runs",
    "run_tree": "_runs",
    "scene_text": "_scenes",
    "sweep": "_sweeps",
    "tangential_stiffness": "_kernels",
    "view": "_drawing",
}
__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> object:
    """What is asked for first now."""
    if name == "__version__":
        from importlib.metadata import version

        value: object = version("contensou")
    elif name in _HOMES:
        value = getattr(importlib.import_module(f"contensou.{_HOMES[name]}"), name)
    else:
        raise AttributeError(f"module 'contensou' has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
