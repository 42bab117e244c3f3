"""Check the layer order of the Fortran sources and the names of their modules.

A file of the layer <layer> may use modules of its own layer and of those before it:

    base < special < contact < dynamics < integrate < scene < study < files < compare < sweep
    < contensou (the facade) < capi < drivers

Also checked: a module is named after its path (src/base/kinds.f90 holds contensou_base_kinds), a
module that is used exists, SUNDIALS is named in one file at most, and HDF5 in the C files of
src/files that write and read it.

    check_layers.py [ROOT]

Prints one line per finding, "file:line: what is wrong". Exit status 0 when there is none, else 1.
"""

import re
import sys
from pathlib import Path

LAYERS = (
    "base",
    "special",
    "contact",
    "dynamics",
    "integrate",
    "scene",
    "study",
    "files",
    "compare",
    "sweep",
    "contensou",
    "capi",
    "drivers",
)
SUFFIXES = (".f90", ".F90", ".f90.in", ".F90.in")

USE = re.compile(r"^\s*use\b(?:\s*,\s*(?:non_)?intrinsic)?\s*(?:::)?\s*(\w+)", re.IGNORECASE)
MODULE = re.compile(r"^\s*(?:module|submodule\s*\([^)]*\))\s+(\w+)\s*(?:!.*)?$", re.IGNORECASE)
INCLUDE = re.compile(r"^\s*#\s*include\s*[<\"]([^>\"]+)[>\"]")

# Libraries that few files may name, by their Fortran modules and by their C headers: those whose
# path is given, else one of any name.
LIBRARIES = {
    "SUNDIALS": (
        re.compile(
            r"f(cvodes?|idas?|arkode|kinsol|sundials|nvector|sunmatrix|sunlinsol|sunnonlinsol)\w*_mod"
        ),
        re.compile(
            r"(cvodes?|idas?|arkode|kinsol|sundials|nvector|sunmatrix|sunlinsol|sunnonlinsol)/"
        ),
        None,
    ),
    "HDF5": (
        re.compile(r"hdf5|h5\w+"),
        re.compile(r"(.*/)?(hdf5|H5\w+|hdf5_hl|hdf5_common)\.h"),
        re.compile(r"src/files/hdf5_(common|writer|reader|seal)\.[ch]"),
    ),
}


class Source:
    """One source file: its layer, the modules it defines and those it uses, with line numbers."""

    def __init__(self, root: Path, path: Path) -> None:
        self.path = path
        relative = path.relative_to(root)
        self.name = relative.as_posix()
        parts = list(relative.parts)
        if parts[0] == "src":
            parts.pop(0)
        parts[-1] = parts[-1].split(".")[0]
        self.module = "_".join(["contensou", *parts]) if parts != ["contensou"] else "contensou"
        # A file straight in src/ gathers the others: it is a layer of its own, named as it is.
        self.layer = parts[0]
        self.defines: list[tuple[int, str]] = []
        self.uses: list[tuple[int, str]] = []
        self.includes: list[tuple[int, str]] = []
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            if found := INCLUDE.match(line):
                self.includes.append((number, found[1]))
            elif path.suffix in (".c", ".h"):
                continue
            elif found := USE.match(line):
                self.uses.append((number, found[1].lower()))
            elif found := MODULE.match(line):
                self.defines.append((number, found[1].lower()))


def sources(root: Path) -> list[Source]:
    """All sources of the library and the drivers, sorted by path."""
    found = []
    for folder in ("src", "drivers"):
        for path in sorted((root / folder).rglob("*")):
            if path.is_file() and path.name.endswith((*SUFFIXES, ".c", ".h")):
                found.append(Source(root, path))
    return found


def check_names(files: list[Source]) -> list[str]:
    """A module is named after its path."""
    return [
        f"{file.name}:{number}: module {name} should be named {file.module}, after its path"
        for file in files
        for number, name in file.defines
        if name != file.module
    ]


def check_order(files: list[Source]) -> list[str]:
    """No file uses a module of a later layer, or one that does not exist."""
    findings = []
    layer_of = {name: file.layer for file in files for _, name in file.defines}
    for file in files:
        if file.layer not in LAYERS:
            findings.append(
                f"{file.name}:1: '{file.layer}' is no layer; there are {', '.join(LAYERS)}"
            )
            continue
        for number, name in file.uses:
            if not name.startswith("contensou"):
                continue
            # Some files are compiled several times, with names of their own (src/meson.build).
            name = name.removesuffix("_widest").removesuffix("_wide").removesuffix("_few")
            if name not in layer_of:
                findings.append(f"{file.name}:{number}: there is no module {name}")
            elif layer_of[name] in LAYERS[LAYERS.index(file.layer) + 1 :]:
                findings.append(
                    f"{file.name}:{number}: layer '{file.layer}' may not use {name} of the later"
                    f" layer '{layer_of[name]}'"
                )
    return findings


def check_libraries(files: list[Source]) -> list[str]:
    """SUNDIALS and HDF5 are each named where they may be, and nowhere else."""
    findings = []
    for library, (module, header, home) in LIBRARIES.items():
        places: dict[str, int] = {}
        for file in files:
            named = [number for number, name in file.uses if module.fullmatch(name)]
            named += [number for number, name in file.includes if header.match(name)]
            if named:
                places[file.name] = min(named)
        if home:
            findings += [
                f"{name}:{number}: {library} is named here; only {home.pattern} may"
                for name, number in places.items()
                if not home.fullmatch(name)
            ]
        elif len(places) > 1:
            findings += [
                f"{name}:{number}: {library} is named here; only one of {', '.join(places)} may"
                for name, number in places.items()
            ]
    return findings


def main() -> int:
    """Check the project and print what is wrong with it."""
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent.parent).resolve()
    files = sources(root)
    findings = check_names(files) + check_order(files) + check_libraries(files)
    if not files:
        findings = [f"{root}: no sources in src and drivers"]
    print("\n".join(findings), end="\n" if findings else "")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
