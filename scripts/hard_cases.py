"""Run the hard cases with their pictures, and write the list of them in docs/hard-cases.md."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap

from lib import program

PAGE = program.ROOT / "docs" / "hard-cases.md"
FIRST, LAST = "<!-- The list: scripts/hard_cases writes it -->", "<!-- End of the list -->"


def wrapped(prose: str) -> str:
    """A paragraph in lines of at most 100 columns."""
    return textwrap.fill(prose, 100, break_long_words=False, break_on_hyphens=False)


def main() -> int:
    """Draw and write; the status is that of the tests."""
    folder = PAGE.parent / "hard-cases"
    folder.mkdir(exist_ok=True)
    sys.path.insert(0, str(program.ROOT / "tests" / "driver"))
    import test_hard_cases

    listed = [
        f"## {name}\n\n{wrapped(done)}\n\n{wrapped(passes)}\n\n![{name}](hard-cases/{name}.png)\n"
        for name, done, passes in test_hard_cases.cases()
    ]
    before, _, rest = PAGE.read_text().partition(FIRST)
    after = rest.partition(LAST)[2]
    PAGE.write_text(f"{before}{FIRST}\n\n" + "\n".join(listed) + f"\n{LAST}{after}")
    return subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-n", "2", test_hard_cases.__file__],
        env={"CONTENSOU_PICTURES": str(folder)} | os.environ,
        cwd=program.ROOT,
        check=False,
    ).returncode


if __name__ == "__main__":
    sys.exit(main())
