"""A simulation that can be led step by step."""

from __future__ import annotations

import contextlib
import ctypes
import signal
import threading
import time as clock
import warnings
import weakref
from collections.abc import Callable, Iterator, Sequence
from types import FrameType
from typing import Any, NamedTuple

import numpy as np
import xarray
from numpy.typing import ArrayLike

from contensou import _arguments as arguments
from contensou import _library as lib
from contensou._errors import SceneError, SceneWarning
from contensou._scenes import Scene, Settings, settings_texts, text_or_name

KINDS = {1: "touch", 2: "lift"}

# How a body moves: CONTENSOU_FREE of the header.
FREE = 0

# Interrupts are heard after so much wall time, about [s].
SLICE = 0.05


class Event(NamedTuple):
    """A contact touched or lifted off."""

    #: When [s].
    time: float
    #: "touch" or "lift".
    kind: str
    #: Name of the contact.
    contact: str


class Body(NamedTuple):
    """Motion of a body, inertial frame but for what is said otherwise."""

    #: Centre of mass [m], shape (3,).
    position: np.ndarray
    #: Attitude, body to inertial frame, real part first, shape (4,).
    quaternion: np.ndarray
    #: Of the centre of mass [m/s], shape (3,).
    velocity: np.ndarray
    #: In the axes of the body [rad/s], shape (3,).
    angular_velocity: np.ndarray


class Load(NamedTuple):
    """What acts on a body, but for its weight."""

    #: At the centre of mass, inertial frame [N], shape (3,).
    force: np.ndarray
    #: About the centre of mass, in the axes of the body [N m], shape (3,).
    torque: np.ndarray


class Parameter(NamedTuple):
    """A number of the scene that can be set."""

    #: As in settings: "top.spin(3)".
    name: str
    unit: str
    description: str
    value: float
    #: Bounds of its domain.
    low: float
    high: float
    #: Whether the scene or a setting gives it.
    is_given: bool


class Quantity(NamedTuple):
    """A quantity of rows."""

    name: str
    units: str
    description: str
    #: Sizes, of `dims`.
    shape: tuple[int, ...]
    dims: tuple[str, ...]


class Snapshot(NamedTuple):
    """Where a simulation has come to, as bytes that can be kept, sent and pickled."""

    data: bytes

    def __repr__(self) -> str:
        return f"<contensou.Snapshot of {len(self.data)} bytes>"


class Simulation:
    """A scene, its equations of motion, and how far its simulation has come.

    Several threads may use different simulations at the same time; one simulation serves one thread
    after the other.

    Parameters
    ----------
    scene
        Name of a scene file, text of a scene, or dictionary of its groups.
    settings
        Values that differ, by path, or texts as after `--set`.

    Examples
    --------
    >>> top = Simulation("tippe_top.nml", {"top.spin": (0, 0, 200)})
    >>> top.advance(0.01)
    0.01
    >>> top.body("top").position.shape
    (3,)
    >>> there = top.save()
    >>> later = top.step(0.01)
    >>> top.restore(there)
    >>> top.time
    0.01
    """

    def __init__(self, scene: Scene, settings: Settings = None) -> None:
        text, name = text_or_name(scene)
        words, n = lib.texts(settings_texts(settings))
        encoded = None if text is None else lib.encoded(text, "scene")
        self._own(lib.call("simulation_make", lib.INTERFACE, lib.encoded(name), encoded, words, n))
        if said := self._text("simulation_warnings").strip():
            warnings.warn(said, SceneWarning, stacklevel=2)

    def _own(self, handle: int) -> None:
        """Take a simulation of the library, which goes with this object."""
        self._handle: int | None = handle
        self._release = weakref.finalize(self, lib.library.contensou_simulation_free, handle)
        self._lock = threading.RLock()
        self._busy = self._in_row = self._ended = False
        self._interrupt: tuple[int, FrameType | None] | None = None
        self._problem: BaseException | None = None
        self._on_row: Callable[[Simulation], object] | None = None
        #: Touches and lifts so far, as `Event`.
        self.events: list[Event] = []
        self.bodies = self._names("body_name", "bodies")
        self.contacts = self._names("contact_name", "contacts")
        # Mass [kg], inertia [kg m2] and gravity [m/s2] of bodies whose loads were asked for.
        self._inertias: dict[str, tuple[float, np.ndarray, np.ndarray]] = {}
        # These must live as long as the library may call them; they know the simulation weakly.
        known = weakref.ref(self)
        self._row = lib.RowCallback(lambda *_: _heard(known, Simulation._hear_row))
        self._event = lib.EventCallback(
            lambda t, kind, contact, _: _heard(known, Simulation._hear_event, t, kind, contact)
        )
        lib.plain("simulation_observe", handle, self._row, self._event, None)

    # ---- What it is --------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """The present [s]."""
        return float(self._plain("simulation_time"))

    @property
    def end(self) -> float:
        """End of the scene [s]."""
        return float(self._plain("simulation_end"))

    @property
    def stop(self) -> int:
        """Number of the condition (&stop) that has ended it, from 1; 0 if none has."""
        return int(self._plain("simulation_stop"))

    @property
    def settings(self) -> str:
        """All settings of the scene, defaults included, as a scene."""
        return self._text("simulation_settings")

    @property
    def state(self) -> np.ndarray:
        """The state at the present, shape (n,), a copy; it can be set.

        Of each body position (3) [m], quaternion (4), velocity (3) [m/s] and angular velocity (3)
        in its own axes [rad/s]; then states of laws, then works [J].
        """
        values = np.empty(int(self._plain("simulation_size")))
        self._plain("simulation_state", values)
        return values

    @state.setter
    def state(self, values: ArrayLike) -> None:
        y = lib.numbers(values, "state")
        with self._alone() as handle:
            lib.call("simulation_set_state", handle, y.ravel(), y.size)

    def body(self, name: str) -> Body:
        """Motion of a body at the present."""
        found = Body(np.empty(3), np.empty(4), np.empty(3), np.empty(3))
        if self._plain("simulation_body", lib.encoded(name), *found) != 0:
            raise SceneError(f"there is no body {name!r}; there are: {', '.join(self.bodies)}", 2)
        return found

    def set_body(
        self,
        name: str,
        position: ArrayLike | None = None,
        quaternion: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        angular_velocity: ArrayLike | None = None,
    ) -> None:
        """Set the motion of a body at the present; what is not given stays. Units as of `Body`."""
        state = self.state
        start = self._start_of(name)
        for size, values in ((3, position), (4, quaternion), (3, velocity), (3, angular_velocity)):
            if values is not None:
                state[start : start + size] = _vector(values, "motion of a body", size)
            start += size
        self.state = state

    def load(self, body: str) -> Load:
        """What acts on a free body at the present, but for its weight.

        Contacts, springs, links and applied loads: what another program, which integrates the
        motion, needs of this one, after `set_body`.

        >>> top = Simulation("tippe_top.nml")
        >>> top.set_body("top", position=(0, 0, 0.1))
        >>> top.load("top").force.round(9).tolist()
        [0.0, 0.0, 0.0]
        """
        start = self._start_of(body)
        if body not in self._inertias:
            self._inertias[body] = self._inertia_of(body)
        mass, inertia, gravity = self._inertias[body]
        state = self.state
        x, y, z = state[start + 10 : start + 13]
        rate = self.derivative(state=state)[start : start + 13]
        one, two, three = inertia
        gyroscopic = ((three - two) * y * z, (one - three) * z * x, (two - one) * x * y)
        return Load(mass * (rate[7:10] - gravity), inertia * rate[10:] + gyroscopic)

    def _inertia_of(self, body: str) -> tuple[float, np.ndarray, np.ndarray]:
        """Mass [kg], principal moments of inertia [kg m2] of a free body, and gravity [m/s2]."""
        if self._plain("simulation_motion", self.bodies.index(body)) != FREE:
            raise SceneError(f"body {body!r} does not move freely: no load is told", 2)
        known = self.parameters
        # The group stands before a name that is not of a body alone.
        path = body if f"{body}.mass" in known else f"body.{body}"
        inertia, gravity = (
            np.array([known[f"{name}({i})"].value for i in (1, 2, 3)])
            for name in (f"{path}.inertia", "scene.gravity")
        )
        return known[f"{path}.mass"].value, inertia, gravity

    def _start_of(self, body: str) -> int:
        """Where the motion of a body begins in the state."""
        if body not in self.bodies:
            raise SceneError(f"there is no body {body!r}; there are: {', '.join(self.bodies)}", 2)
        return 13 * self.bodies.index(body)

    @property
    def quantities(self) -> dict[str, Quantity]:
        """Quantities of rows by name, as in the group `/trajectory` of a file."""
        found = {}
        for i in range(int(self._plain("simulation_quantities"))):
            one = lib.QuantityStruct()
            self._plain("simulation_quantity", i, ctypes.byref(one))
            dims = [dim.decode() for dim in one.dims[: one.rank]]
            quantity = Quantity(
                one.name.decode(),
                one.units.decode(),
                one.description.decode(),
                tuple(one.shape[: one.rank]),
                tuple(dims),
            )
            found[quantity.name] = quantity
        return found

    def values(self, name: str) -> np.ndarray:
        """A quantity at the present, in its shape and unit: see `quantities`."""
        found = self._known([name])[name]
        values = np.empty(found.shape)
        with self._held() as handle:
            flat = values.reshape(-1)
            lib.call("simulation_values", handle, lib.encoded(name), flat, values.size)
        return values

    @property
    def parameters(self) -> dict[str, Parameter]:
        """Numbers of the scene that can be set, by name."""
        found = {}
        for i in range(int(self._plain("simulation_parameters"))):
            one = lib.ParameterStruct()
            self._plain("simulation_parameter", i, ctypes.byref(one))
            parameter = Parameter(
                one.name.decode(),
                one.unit.decode(),
                one.description.decode(),
                one.value,
                one.low,
                one.high,
                one.is_given,
            )
            found[parameter.name] = parameter
        return found

    # ---- Going on ----------------------------------------------------------------------------

    def advance(
        self, time: float | None = None, on_row: Callable[[Simulation], object] | None = None
    ) -> float:
        """Go on to a time [s], the end of the scene if not given; the time reached.

        It ends before where a condition of the scene (&stop) is met, and where `on_row`, which is
        called with this simulation every `output.interval`, returns something true. The bits of
        rows do not depend on the times gone to.
        """
        return self._advance("simulation_advance", time, on_row)

    def step(self, duration: float) -> float:
        """Go on for a while [s]; the time reached."""
        return self.advance(self.time + arguments.number(duration, "duration"))

    def advance_to_event(self, time: float | None = None) -> Event | None:
        """Go on to the next touch or lift, or to a time [s]; the event, if there is one."""
        before = len(self.events)
        self._advance("simulation_advance_to_event", time, None)
        return self.events[-1] if len(self.events) > before else None

    def _known(self, names: Sequence[str] | None) -> dict[str, Quantity]:
        """The quantities of some names, or of all; an error if there are none of a name."""
        known = self.quantities
        if names is None:
            return known
        wanted = arguments.names(names, "quantities")
        if missing := [name for name in wanted if name not in known]:
            there = ", ".join(known)
            raise SceneError(f"there is no quantity {missing[0]!r}; there are: {there}", 2)
        return {name: known[name] for name in wanted}

    def rows(self, names: Sequence[str] | None = None, time: float | None = None) -> xarray.Dataset:
        """Go on to a time [s], and keep the rows on the way.

        Parameters
        ----------
        names
            Quantities; all if not given.
        time
            Where to go to; the end of the scene if not given.

        Returns
        -------
        xarray.Dataset
            As of `contensou.run`, with the same bits.
        """
        known = self._known(names)
        wanted = list(known)
        times: list[float] = []
        columns: dict[str, list[np.ndarray]] = {name: [] for name in wanted}

        def keep(now: Simulation) -> None:
            times.append(now.time)
            for name, column in columns.items():
                values = np.empty(known[name].shape)
                flat = values.reshape(-1)
                lib.call("simulation_values", now._handle, name.encode(), flat, values.size)
                column.append(values)

        self.advance(time, keep)
        labels = {
            "body": self.bodies,
            "contact": self.contacts,
            "xyz": list("xyz"),
            "wxyz": list("wxyz"),
            "axis": ["major", "minor"],
        }
        used = {dim for name in wanted for dim in known[name].dims}
        table = xarray.Dataset(
            coords={
                "time": ("time", times, {"units": "s", "long_name": "time"}),
                **{dim: labels[dim] for dim in labels if dim in used},
            }
        )
        for name, column in columns.items():
            about = {"units": known[name].units, "long_name": known[name].description}
            values = np.array(column).reshape(len(times), *known[name].shape)
            table[name] = (("time", *known[name].dims), values, about)
        return table

    def reset(self) -> None:
        """Go back to the beginning, with the parameters as they are."""
        with self._alone() as handle:
            lib.call("simulation_reset", handle)
            self.events.clear()

    def set(self, settings: Settings) -> None:
        """Set parameters at the beginning, or after a reset, and begin with them.

        Values by path, or texts as after `--set`; nothing changes if there is a mistake.
        """
        words, n = lib.texts(settings_texts(settings))
        with self._alone() as handle:
            lib.call("simulation_set_text", handle, words, n)
            self._inertias.clear()

    def set_load(
        self, body: str, force: Sequence[float] = (0, 0, 0), torque: Sequence[float] = (0, 0, 0)
    ) -> None:
        """Let a force at the centre of mass [N] and a torque [N m] act on a body from now on."""
        pair = [_vector(force, "force"), _vector(torque, "torque")]
        with self._alone() as handle:
            lib.call("simulation_set_load", handle, lib.encoded(body), *pair)

    def set_drive(
        self,
        body: str,
        acceleration: Sequence[float] = (0, 0, 0),
        angular_acceleration: Sequence[float] = (0, 0, 0),
    ) -> None:
        """Let the drive of a body accelerate it [m/s2], [rad/s2], beside what the scene says."""
        pair = [_vector(acceleration, "acceleration")]
        pair.append(_vector(angular_acceleration, "angular_acceleration"))
        with self._alone() as handle:
            lib.call("simulation_set_drive", handle, lib.encoded(body), *pair)

    # ---- Equations ---------------------------------------------------------------------------

    def derivative(self, time: float | None = None, state: Any = None) -> np.ndarray:
        """Time derivative of a state, shape (n,), with contacts closed as at the present."""
        return self._function("simulation_derivative", time, state, lambda n: (n,))

    def jacobian(self, time: float | None = None, state: Any = None) -> np.ndarray:
        """Derivatives of that by the state, shape (n, n): row i for rate i."""
        return self._function("simulation_jacobian", time, state, lambda n: (n, n))

    def indicators(self, time: float | None = None, state: Any = None) -> np.ndarray:
        """Functions that pass through zero at touch and lift-off, shape (contacts,): gaps [m]."""
        return self._function("simulation_indicators", time, state, lambda n: (len(self.contacts),))

    def _function(
        self, name: str, time: float | None, state: Any, shape: Callable[[int], tuple[int, ...]]
    ) -> np.ndarray:
        y = self.state if state is None else lib.numbers(state, "state").ravel()
        t = self.time if time is None else arguments.number(time, "time")
        size = int(self._plain("simulation_size"))
        values = np.empty(shape(size))
        with self._held() as handle:
            lib.call(name, handle, t, y, y.size, values.reshape(-1))
        return values

    # ---- Copies ------------------------------------------------------------------------------

    def save(self) -> Snapshot:
        """Keep where this has come to; what follows is the same, bit for bit, after `restore`.

        It ends the step under way, so what follows is within the tolerance of a run without it.
        """
        with self._alone() as handle:
            snapshot = lib.call("simulation_save", handle)
            try:
                size = ctypes.c_size_t()
                place: Any = lib.plain("snapshot_bytes", snapshot, ctypes.byref(size))
                return Snapshot(ctypes.string_at(place, size.value))
            finally:
                lib.plain("snapshot_free", snapshot)

    def restore(self, snapshot: Snapshot) -> None:
        """Go where a simulation of the same scene with the same settings has been."""
        if not isinstance(snapshot, Snapshot) or not isinstance(snapshot.data, bytes):
            shown = arguments.shown(getattr(snapshot, "data", snapshot))
            raise SceneError(f"snapshot: expected what save() has given, not {shown}", 2)
        with self._alone() as handle:
            taken = lib.call("snapshot_new", snapshot.data, len(snapshot.data))
            try:
                lib.call("simulation_restore", handle, taken)
            finally:
                lib.plain("snapshot_free", taken)
            self.events = [event for event in self.events if event.time <= self.time]

    def copy(self) -> Simulation:
        """A second simulation like this one."""
        with self._alone() as handle:
            second = object.__new__(Simulation)
            second._own(lib.call("simulation_copy", handle))
            second.events = list(self.events)
            return second

    def close(self) -> None:
        """Release it; to use it after that is an error. It goes by itself, too."""
        if self._handle is None:
            return
        with self._alone():
            self._handle = None
            self._release()

    def __enter__(self) -> Simulation:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        if self._handle is None:
            return "<contensou.Simulation, closed>"
        return (
            f"<contensou.Simulation of {len(self.bodies)} bodies, "
            f"{len(self.contacts)} contacts, at {self.time:g} s>"
        )

    # ---- How it is done ----------------------------------------------------------------------

    @contextlib.contextmanager
    def _held(self) -> Iterator[int]:
        """The handle, for this thread alone."""
        with self._lock:
            if self._handle is None:
                raise SceneError("this simulation is closed", 2)
            yield self._handle

    @contextlib.contextmanager
    def _alone(self) -> Iterator[int]:
        """The handle, if nothing runs: what looks at rows must not change the simulation."""
        with self._held() as handle:
            if self._busy:
                raise SceneError("the simulation is running", 2)
            yield handle

    def _plain(self, name: str, *words: object) -> Any:
        with self._held() as handle:
            return lib.plain(name, handle, *words)

    def _text(self, name: str) -> str:
        return str(self._plain(name).decode())

    def _names(self, one: str, all_of_them: str) -> list[str]:
        count = self._plain(f"simulation_{all_of_them}")
        return [self._plain(f"simulation_{one}", i).decode() for i in range(count)]

    def _advance(
        self, how: str, time: float | None, on_row: Callable[[Simulation], object] | None
    ) -> float:
        """Go on in slices, between which Python hears interrupts."""
        target = self.end if time is None else arguments.number(time, "time")
        if on_row is not None and not callable(on_row):
            shown = arguments.shown(on_row)
            raise SceneError(f"on_row: expected a function of a simulation, not {shown}", 2)
        with self._alone() as handle, self._interrupts():
            events = len(self.events)
            self._busy, self._problem, self._on_row, self._ended = True, None, on_row, False
            try:
                span = (target - self.time) / 1000
                while True:
                    now = self.time
                    goal = target if not span > 0 else min(target, now + span)
                    goal = target if goal <= now or target - goal < span / 2 else goal
                    begun = clock.monotonic()
                    lib.call(how, handle, goal)
                    if self._problem is not None:
                        raise self._problem
                    if goal >= target or self.time < goal or self._ended or self._interrupt:
                        break
                    if how.endswith("event") and len(self.events) > events:
                        break
                    taken = clock.monotonic() - begun
                    span *= 2 if taken < SLICE / 2 else 0.5 if taken > 2 * SLICE else 1
            finally:
                self._busy, self._problem, self._on_row = False, None, None
            return self.time

    @contextlib.contextmanager
    def _interrupts(self) -> Iterator[None]:
        """Keep an interrupt until the library has returned: what it calls cannot raise it."""
        before = signal.getsignal(signal.SIGINT)
        if threading.current_thread() is not threading.main_thread() or not callable(before):
            yield
            return

        def note(number: int, frame: FrameType | None) -> None:
            if self._in_row:
                before(number, frame)
            else:
                self._interrupt = (number, frame)

        signal.signal(signal.SIGINT, note)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, before)
            kept, self._interrupt = self._interrupt, None
            if kept is not None:
                before(*kept)

    def _hear_row(self) -> int:
        if self._on_row is not None:
            self._in_row = True
            try:
                self._ended = bool(self._on_row(self))
            finally:
                self._in_row = False
        return int(self._ended or self._interrupt is not None)

    def _hear_event(self, time: float, kind: int, contact: int) -> int:
        self.events.append(Event(time, KINDS[kind], self.contacts[contact]))
        return int(self._interrupt is not None)


def _heard(known: weakref.ref[Simulation], hear: Callable[..., int], *words: object) -> int:
    """Call back; an exception ends the simulation, and goes to who advances it."""
    simulation = known()
    if simulation is None:
        return 1
    try:
        return hear(simulation, *words)
    except BaseException as problem:
        simulation._problem = problem
        return 1


def _vector(values: ArrayLike, what: str, size: int = 3) -> np.ndarray:
    vector = lib.numbers(values, what)
    if vector.shape != (size,):
        raise SceneError(f"{what}: expected {size} numbers", 2)
    return vector
