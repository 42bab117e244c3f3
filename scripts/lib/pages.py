"""HTML files that need nothing else: data, style and scripts in one."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

PARTS = Path(__file__).resolve().parent / "view"

# The scripts of each page, in the order in which they run.
SCRIPTS = {
    "view": ("common", "motion", "shapes", "spot", "springs", "charts", "view"),
    "sweep": ("common", "sweep"),
}


class Package:
    """Numbers in binary behind a head in JSON, for the page."""

    def __init__(self) -> None:
        self.blocks: list[bytes] = []
        self.length = 0

    def put(self, values: np.ndarray, kind: str) -> list:
        """Append an array; what the head says of it: kind, place, count."""
        data = np.ascontiguousarray(values, dtype="<" + kind).tobytes()
        place = [kind, self.length, int(np.size(values))]
        data += bytes(-len(data) % 8)
        self.blocks.append(data)
        self.length += len(data)
        return place

    def text(self, head: dict) -> str:
        """Head and numbers, compressed, in base64."""
        words = json.dumps(head, allow_nan=False, separators=(",", ":")).encode()
        words += b" " * (-(len(words) + 8) % 8)
        start = np.array([len(words), 0], dtype="<u4").tobytes()
        return base64.b64encode(zlib.compress(b"".join([start, words, *self.blocks]), 9)).decode(
            "ascii"
        )


def library() -> str:
    """three.js as one script: its two modules, as they are delivered, as functions."""
    core = (PARTS / "three" / "three.core.min.js").read_text(encoding="utf-8")
    module = (PARTS / "three" / "three.module.min.js").read_text(encoding="utf-8")

    def entries(words: str, ours: str) -> str:
        pairs = [word.split(" as ") for word in words.split(",")]
        return ",".join(ours.format(pair[0], pair[-1]) for pair in pairs)

    core = re.sub(
        r"export\{([^}]*)\};?\s*$", lambda m: "return{" + entries(m[1], "{1}:{0}") + "};", core
    )
    module = re.sub(
        r'import\{([^}]*)\}from"\./three\.core\.min\.js";',
        lambda m: "const{" + entries(m[1], "{0}:{1}") + "}=core;",
        module,
    )
    module = re.sub(r'export\{[^}]*\}from"\./three\.core\.min\.js";', "", module)
    module = re.sub(
        r"export\{([^}]*)\};?\s*$",
        lambda m: "return{...core," + entries(m[1], "{1}:{0}") + "};",
        module,
    )
    return (
        'const THREE=(()=>{"use strict";const core=(()=>{"use strict";'
        + core
        + "\n})();\n"
        + module
        + "\n})();"
    )


def page(name: str, data: str, libraries: Sequence[str] = ()) -> str:
    """The whole page of the parts of a name. Nothing of the file is in it but in base64; scripts
    and styles run only if they are those written here, and nothing can be fetched."""

    def part(file: str) -> str:
        return (PARTS / file).read_text(encoding="utf-8")

    style = part("common.css") + part(f"{name}.css")
    scripts = [*libraries, *(part(f"{script}.js") for script in SCRIPTS[name])]
    for script in scripts:
        assert "</script" not in script.lower()
        assert "<!--" not in script

    def hashed(text: str) -> str:
        digest = hashlib.sha256(text.encode()).digest()
        return f"'sha256-{base64.b64encode(digest).decode()}'"

    policy = (
        f"default-src 'none'; script-src {' '.join(map(hashed, scripts))}; "
        f"style-src {hashed(style)}; img-src data: blob:; base-uri 'none'; form-action 'none'"
    )
    return "\n".join(
        [
            "<!doctype html>",
            '<html lang="en"><head><meta charset="utf-8">',
            f'<meta http-equiv="Content-Security-Policy" content="{policy}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            "<title>contensou</title>",
            f"<style>{style}</style></head><body>",
            part(f"{name}.html"),
            f'<script type="text/plain" id="data">{data}</script>',
            *(f"<script>{script}</script>" for script in scripts),
            "</body></html>\n",
        ]
    )
