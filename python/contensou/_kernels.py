"""Kernels on arrays of NumPy, which broadcast, without the lock of the interpreter."""

from __future__ import annotations

import ctypes
import math
import threading
import weakref
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from contensou import _arguments as arguments
from contensou import _library as lib
from contensou._errors import SceneError


class Elliptic(NamedTuple):
    """Complete elliptic integrals."""

    #: Of the first kind [1].
    k: np.ndarray
    #: Of the second kind [1].
    e: np.ndarray


class Hertz(NamedTuple):
    """Hertz contacts."""

    #: Semi-axis of the spot along x, the major one [m].
    a: np.ndarray
    #: Semi-axis of the spot along y [m].
    b: np.ndarray
    #: Normal force [N].
    force: np.ndarray
    #: Largest pressure [Pa].
    pressure: np.ndarray


class Wrench(NamedTuple):
    """Friction on the body that slips."""

    #: Force along x [N].
    fx: np.ndarray
    #: Force along y [N].
    fy: np.ndarray
    #: Torque about the normal [N m].
    tz: np.ndarray


def elliptic(complement: ArrayLike) -> Elliptic:
    """Complete elliptic integrals K and E.

    Parameters
    ----------
    complement
        Complement 1 - k^2 of the parameter [1], in [0, 1]; any shape.

    Returns
    -------
    Elliptic
        K and E [1], of the same shape; NaN outside of the domain.

    Examples
    --------
    >>> k, e = elliptic([1.0, 0.5])
    >>> k.round(12).tolist()
    [1.570796326795, 1.854074677301]
    """
    return Elliptic(*_columns("elliptic_array", 2, {"complement": complement}))


def hertz(
    curvature_a: ArrayLike, curvature_b: ArrayLike, modulus: ArrayLike, approach: ArrayLike
) -> Hertz:
    """Hertz contacts of bodies whose undeformed gap is A x^2 + B y^2.

    Parameters
    ----------
    curvature_a, curvature_b
        A > 0 and B >= A [1/m]; both are 1/(2R) for a sphere of radius R on a plane.
    modulus
        Effective modulus E* [Pa], > 0.
    approach
        d [m], >= 0.

    Returns
    -------
    Hertz
        `a`, `b` [m], `force` [N], `pressure` [Pa], of the shape to which the arguments broadcast;
        NaN outside of the domain.

    Examples
    --------
    >>> found = hertz(50.0, 50.0, 1.1e11, [1e-6, 2e-6])
    >>> found.force.round(3).tolist()
    [14.667, 41.484]
    """
    named: dict[str, ArrayLike] = {
        "curvature_a": curvature_a,
        "curvature_b": curvature_b,
        "modulus": modulus,
        "approach": approach,
    }
    return Hertz(*_columns("hertz_array", 4, named))


class Slopes(NamedTuple):
    """Friction on the body that slips, and its derivatives."""

    #: Force along x and y [N], torque about the normal [N m].
    wrench: Wrench
    #: Derivatives of the three (second last index) by load, a at constant b/a, vx, vy and spin
    #: (last index), SI.
    slopes: np.ndarray


class Stiffness(NamedTuple):
    """Stiffness of spots on which nothing slips."""

    #: Along x and y [N/m].
    kx: np.ndarray
    ky: np.ndarray
    #: About the normal [N m/rad].
    kt: np.ndarray


class Steps(NamedTuple):
    """Steps of a spot with local slip and memory."""

    #: Force along x and y [N] and torque about the normal [N m] on body 1, after the step.
    fx: np.ndarray
    fy: np.ndarray
    tz: np.ndarray
    #: Elastic energy after the step [J].
    energy: np.ndarray
    #: What was lost in the step [J].
    lost: np.ndarray


class Friction:
    """A friction model with its parameters.

    Parameters
    ----------
    model
        "coulomb", "contensou_simplified", "pade11", "pade22" or "contensou_exact".
    coefficient
        Friction coefficient f [1], >= 0.
    delta
        Regularisation velocity [m/s], >= 0, and > 0 for "coulomb".
    drilling
        Whether the drilling torque is part of the model.

    Examples
    --------
    >>> friction = Friction("contensou_exact", 0.3)
    >>> found = friction.wrench(10.0, 1e-3, 1e-3, [0.1, 0.1], 0.0, [0.0, 100.0])
    >>> found.fx.round(6).tolist()
    [-3.0, -2.650719]
    """

    def __init__(
        self, model: str, coefficient: float, delta: float = 0.0, drilling: bool = True
    ) -> None:
        coefficient = arguments.number(coefficient, "coefficient")
        delta = arguments.number(delta, "delta")
        encoded = lib.encoded(model, "model")
        handle = lib.plain("friction_new", encoded, coefficient, delta, bool(drilling))
        if handle is None:
            raise SceneError(
                f"there is no friction {model!r} with the coefficient {coefficient} and delta "
                f"{delta} m/s",
                2,
            )
        self._handle = handle
        weakref.finalize(self, lib.library.contensou_friction_free, handle)
        self._words = f"{model!r}, {coefficient}, {delta}, {drilling}"

    def __repr__(self) -> str:
        return f"contensou.Friction({self._words})"

    def wrench(
        self,
        load: ArrayLike,
        a: ArrayLike,
        b: ArrayLike,
        vx: ArrayLike,
        vy: ArrayLike,
        spin: ArrayLike,
    ) -> Wrench:
        """Friction on the body that slips.

        Parameters
        ----------
        load
            Normal force N [N], >= 0.
        a, b
            Semi-axes of the spot along x and y [m], 0 < b <= a.
        vx, vy
            Sliding velocity of the centre of the spot [m/s].
        spin
            Angular velocity about the normal [rad/s].

        Returns
        -------
        Wrench
            `fx`, `fy` [N], `tz` [N m], of the shape to which the arguments broadcast; NaN outside
            of the domain.
        """
        inputs, shape, places, strides = _inputs(load=load, a=a, b=b, vx=vx, vy=vy, spin=spin)
        found = np.empty((*shape, 3))
        lib.plain(
            "friction_wrench_array",
            self._handle,
            found.size // 3,
            places,
            strides,
            found.ctypes.data,
        )
        del inputs
        return Wrench(*(found[..., i] for i in range(3)))

    def jacobian(
        self,
        load: ArrayLike,
        a: ArrayLike,
        b: ArrayLike,
        vx: ArrayLike,
        vy: ArrayLike,
        spin: ArrayLike,
    ) -> Slopes:
        """Friction on the body that slips, and its derivatives.

        Parameters
        ----------
        load, a, b, vx, vy, spin
            As of `wrench`.

        Returns
        -------
        Slopes
            `wrench`, of the shape to which the arguments broadcast, and `slopes`, with two more
            dimensions, 3 and 5; NaN outside of the domain.

        Examples
        --------
        >>> found = Friction("contensou_exact", 0.3).jacobian(10.0, 1e-3, 1e-3, 0.1, 0.0, 100.0)
        >>> found.slopes.shape, float(found.slopes[0, 0].round(6))
        ((3, 5), -0.265072)
        """
        inputs, shape, places, strides = _inputs(load=load, a=a, b=b, vx=vx, vy=vy, spin=spin)
        found, slopes = np.empty((*shape, 3)), np.empty((*shape, 3, 5))
        lib.plain(
            "friction_jacobian_array",
            self._handle,
            found.size // 3,
            places,
            strides,
            found.ctypes.data,
            slopes.ctypes.data,
        )
        del inputs
        return Slopes(Wrench(*(found[..., i] for i in range(3))), slopes)


def tangential_stiffness(
    a: ArrayLike, b: ArrayLike, shear_modulus: ArrayLike, poisson: ArrayLike
) -> Stiffness:
    """Stiffness of spots on which nothing slips.

    Parameters
    ----------
    a, b
        Semi-axes of the spot along x and y [m], 0 < b <= a.
    shear_modulus
        G of both bodies together [Pa], 1/G = (1/G1 + 1/G2)/2.
    poisson
        nu of both together [1], nu/G = (nu1/G1 + nu2/G2)/2.

    Returns
    -------
    Stiffness
        `kx`, `ky` [N/m], `kt` [N m/rad], of the shape to which the arguments broadcast; NaN outside
        of the domain.

    Examples
    --------
    >>> found = tangential_stiffness(1e-3, 1e-3, 8e10, 0.3)  # 4 G a/(2 - nu), 8/3 G a^3
    >>> float(found.kx.round(-2)), float(found.kt.round(4))
    (188235300.0, 213.3333)
    """
    named = {"a": a, "b": b, "shear_modulus": shear_modulus, "poisson": poisson}
    return Stiffness(*_columns("tangential_stiffness_array", 3, named))


class Tangential:
    """A spot with local slip, which remembers.

    Parameters
    ----------
    shear_modulus
        G of both bodies together [Pa], > 0, as of `tangential_stiffness`.
    poisson
        nu of both together [1], from -1 to 1/2.
    layers
        From 1 to 128; 0 for one spring without local slip; if left out, as many as a scene has.

    Examples
    --------
    >>> spot = Tangential(8e10, 0.3)
    >>> found = spot.advance(0.6, 1e-4, 1e-4, [1e-8, 0.0, -1e-8], 0.0, 0.0)
    >>> found.fx.round(4).tolist()
    [-0.178, -0.178, 0.0052]
    """

    def __init__(self, shear_modulus: float, poisson: float, layers: int | None = None) -> None:
        shear_modulus = arguments.number(shear_modulus, "shear_modulus")
        poisson = arguments.number(poisson, "poisson")
        number, told = -1, ""
        if layers is not None:
            # More than there can be are as many as C can have, where -1 is what is not told.
            number = min(arguments.whole(layers, "layers"), 2**31 - 1)
            told = f" and {number} layers"
            number = -2 if number < 0 else number
        handle = lib.plain("tangential_new", shear_modulus, poisson, number)
        if handle is None:
            raise SceneError(
                f"there is no spot with the shear modulus {shear_modulus} Pa and Poisson's ratio "
                f"{poisson}{told}",
                2,
            )
        self._handle = handle
        self._lock = threading.Lock()
        weakref.finalize(self, lib.library.contensou_tangential_free, handle)
        self._words = f"{shear_modulus}, {poisson}" + ("" if layers is None else f", {layers}")

    def __repr__(self) -> str:
        return f"contensou.Tangential({self._words})"

    def advance(
        self,
        limit: ArrayLike,
        a: ArrayLike,
        b: ArrayLike,
        x: ArrayLike,
        y: ArrayLike,
        twist: ArrayLike,
    ) -> Steps:
        """Steps one after the other, in the order of the elements.

        Parameters
        ----------
        limit
            Limit f N of the friction force [N], >= 0; without one the spot is open and forgets.
        a, b
            Semi-axes of the spot along x and y [m], 0 < b <= a.
        x, y
            Shift of body 1 against body 2 since the step before [m].
        twist
            Twist about the normal since the step before [rad].

        Returns
        -------
        Steps
            `fx`, `fy` [N], `tz` [N m], `energy`, `lost` [J], of the shape to which the arguments
            broadcast. A step outside of the domain gives NaN and is not remembered.
        """
        named = {"limit": limit, "a": a, "b": b, "x": x, "y": y, "twist": twist}
        with self._lock:
            return Steps(*_columns("tangential_advance_array", 5, named, self._handle))


def _inputs(
    **named: ArrayLike,
) -> tuple[
    list[np.ndarray],
    tuple[int, ...],
    ctypes.Array[ctypes.c_void_p],
    ctypes.Array[ctypes.c_ssize_t],
]:
    """Arrays that live as long as they are used, their common shape, and where they are."""
    columns = [arguments.numbers(values, name) for name, values in named.items()]
    try:
        shape = np.broadcast_shapes(*(column.shape for column in columns))
    except ValueError:
        shapes = ", ".join(
            f"{name} {column.shape}" for name, column in zip(named, columns, strict=True)
        )
        raise SceneError(f"these shapes do not go together: {shapes}", 2) from None
    columns = [
        np.require(column if column.size == 1 else np.broadcast_to(column, shape), None, ["C", "A"])
        for column in columns
    ]
    places = (ctypes.c_void_p * len(columns))(*(column.ctypes.data for column in columns))
    strides = (ctypes.c_ssize_t * len(columns))(*(int(column.size != 1) for column in columns))
    return columns, shape, places, strides


def _columns(
    function: str, outputs: int, named: dict[str, ArrayLike], handle: int | None = None
) -> list[np.ndarray]:
    """The outputs of a kernel, or of a handle's, a column each."""
    inputs, shape, places, strides = _inputs(**named)
    found = np.empty((outputs, *shape))
    size = math.prod(shape)
    to = (ctypes.c_void_p * outputs)(*(found[i, ...].ctypes.data for i in range(outputs)))
    lib.plain(function, *([] if handle is None else [handle]), size, places, strides, to)
    del inputs
    return [found[i, ...] for i in range(outputs)]
