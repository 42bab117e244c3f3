"""The shared library of this package, by ctypes, which lets other threads run meanwhile."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable
from typing import Any

import numpy as np

from contensou import _arguments as arguments
from contensou._errors import error_of
from contensou._prefix import LIBRARY

INTERFACE = 3

Pointer = ctypes.c_void_p
Doubles = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")

#: Looks at a row: time [s], state, its size, data of the user; 0 to go on.
RowCallback = ctypes.CFUNCTYPE(
    ctypes.c_int, ctypes.c_double, ctypes.POINTER(ctypes.c_double), ctypes.c_int, Pointer
)

#: Hears of an event: time [s], kind, contact, data of the user; 0 to go on.
EventCallback = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_double, ctypes.c_int, ctypes.c_int, Pointer)


class ParameterStruct(ctypes.Structure):
    """contensou_parameter of the header."""

    _fields_ = (
        ("name", ctypes.c_char_p),
        ("unit", ctypes.c_char_p),
        ("description", ctypes.c_char_p),
        ("value", ctypes.c_double),
        ("low", ctypes.c_double),
        ("high", ctypes.c_double),
        ("above_low", ctypes.c_bool),
        ("is_integer", ctypes.c_bool),
        ("is_given", ctypes.c_bool),
    )


class QuantityStruct(ctypes.Structure):
    """contensou_quantity of the header."""

    _fields_ = (
        ("name", ctypes.c_char_p),
        ("units", ctypes.c_char_p),
        ("description", ctypes.c_char_p),
        ("size", ctypes.c_int),
        ("rank", ctypes.c_int),
        ("shape", ctypes.c_int * 2),
        ("dims", ctypes.c_char_p * 2),
    )


# Of each function what it returns and what it takes; the error, which many take last, is added.
_int, _double, _text = ctypes.c_int, ctypes.c_double, ctypes.c_char_p
_texts = ctypes.POINTER(ctypes.c_char_p)
_size, _sizes = ctypes.c_ssize_t, ctypes.POINTER(ctypes.c_ssize_t)
_columns = ctypes.POINTER(Pointer)
PLAIN = {
    "interface": (_int,),
    "error_message": (_text, Pointer),
    "error_status": (_int, Pointer),
    "error_free": (None, Pointer),
    "simulation_free": (None, Pointer),
    "simulation_settings": (_text, Pointer),
    "simulation_warnings": (_text, Pointer),
    "simulation_observe": (_int, Pointer, RowCallback, EventCallback, Pointer),
    "simulation_time": (_double, Pointer),
    "simulation_end": (_double, Pointer),
    "simulation_stop": (_int, Pointer),
    "simulation_parameters": (_int, Pointer),
    "simulation_parameter": (_int, Pointer, _int, ctypes.POINTER(ParameterStruct)),
    "simulation_bodies": (_int, Pointer),
    "simulation_contacts": (_int, Pointer),
    "simulation_body_name": (_text, Pointer, _int),
    "simulation_contact_name": (_text, Pointer, _int),
    "simulation_size": (_int, Pointer),
    "simulation_state": (_int, Pointer, Doubles),
    "simulation_motion": (_int, Pointer, _int),
    "simulation_body": (_int, Pointer, _text, Doubles, Doubles, Doubles, Doubles),
    "simulation_quantities": (_int, Pointer),
    "simulation_quantity": (_int, Pointer, _int, ctypes.POINTER(QuantityStruct)),
    "friction_new": (Pointer, _text, _double, _double, ctypes.c_bool),
    "friction_free": (None, Pointer),
    "elliptic_array": (_int, _size, _columns, _sizes, _columns),
    "hertz_array": (_int, _size, _columns, _sizes, _columns),
    "friction_wrench_array": (_int, Pointer, _size, _columns, _sizes, Pointer),
    "friction_jacobian_array": (_int, Pointer, _size, _columns, _sizes, Pointer, Pointer),
    "tangential_stiffness_array": (_int, _size, _columns, _sizes, _columns),
    "tangential_new": (Pointer, _double, _double, _int),
    "tangential_free": (None, Pointer),
    "tangential_advance_array": (_int, Pointer, _size, _columns, _sizes, _columns),
    "snapshot_bytes": (Pointer, Pointer, ctypes.POINTER(ctypes.c_size_t)),
    "snapshot_free": (None, Pointer),
}
FAILING = {
    "simulation_make": (Pointer, _int, _text, _text, _texts, _int),
    "simulation_reset": (_int, Pointer),
    "simulation_advance": (_int, Pointer, _double),
    "simulation_advance_to_event": (_int, Pointer, _double),
    "simulation_set": (_int, Pointer, _texts, Doubles, _int),
    "simulation_set_text": (_int, Pointer, _texts, _int),
    "simulation_set_state": (_int, Pointer, Doubles, _int),
    "simulation_derivative": (_int, Pointer, _double, Doubles, _int, Doubles),
    "simulation_jacobian": (_int, Pointer, _double, Doubles, _int, Doubles),
    "simulation_indicators": (_int, Pointer, _double, Doubles, _int, Doubles),
    "simulation_set_load": (_int, Pointer, _text, Doubles, Doubles),
    "simulation_set_drive": (_int, Pointer, _text, Doubles, Doubles),
    "simulation_values": (_int, Pointer, _text, Doubles, _int),
    "simulation_save": (Pointer, Pointer),
    "simulation_restore": (_int, Pointer, Pointer),
    "simulation_copy": (Pointer, Pointer),
    "snapshot_new": (Pointer, _text, ctypes.c_size_t),
}

library = ctypes.CDLL(str(LIBRARY))
for _name, (_result, *_arguments) in {**PLAIN, **FAILING}.items():
    _function = getattr(library, f"contensou_{_name}")
    _function.restype = _result
    _function.argtypes = [*_arguments, *([ctypes.POINTER(Pointer)] if _name in FAILING else [])]


def call(name: str, *words: object) -> int:
    """Call a function that can fail; an exception with its text if it does."""
    error = Pointer()
    result = getattr(library, f"contensou_{name}")(*words, ctypes.byref(error))
    if error.value is None:
        if FAILING[name][0] is Pointer and result is None:
            raise MemoryError(f"contensou_{name} gave nothing")
        return int(result)
    try:
        message = library.contensou_error_message(error).decode(errors="backslashreplace")
        status = library.contensou_error_status(error)
    finally:
        library.contensou_error_free(error)
    raise error_of(status, message)


def plain(name: str, *words: object) -> Any:
    """Call a function that cannot fail."""
    return getattr(library, f"contensou_{name}")(*words)


def encoded(text: object, what: str = "name") -> bytes:
    """A text as C has it."""
    return arguments.text(text, what).encode()


def texts(found: Iterable[str]) -> tuple[ctypes.Array[ctypes.c_char_p], int]:
    """Texts as an array of C strings, and how many they are."""
    words = [encoded(text) for text in found]
    return (ctypes.c_char_p * max(len(words), 1))(*words), len(words)


def numbers(values: object, what: str) -> np.ndarray:
    """Numbers in a row, as C has them."""
    return np.require(arguments.numbers(values, what), None, ["C", "A"])
