"""Texts as they are shown: on a terminal and as labels."""

from __future__ import annotations

LONGEST = 60  # characters of a name in a label


def shown(text: str) -> str:
    """A text with control characters, and what is no character, as escapes."""
    return "".join(
        c if c.isprintable() or c in "\n\t" else c.encode("unicode_escape").decode() for c in text
    )


def drawn(name: str, longest: int = LONGEST) -> str:
    """A name as a label: without formulas and what commands a terminal, never left out, short."""
    if len(name) > longest:
        name = f"{name[: longest // 2 - 1]}\N{HORIZONTAL ELLIPSIS}{name[-longest // 2 :]}"
    name = shown(name).replace("$", r"\$")
    # A legend leaves out what begins with an underscore.
    return f"\N{ZERO WIDTH SPACE}{name}" if name.startswith("_") else name
