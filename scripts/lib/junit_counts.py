"""Count the test cases of a JUnit file; prints "PASSED FAILED SKIPPED", the skipped on stderr."""

import sys
import xml.etree.ElementTree as ElementTree


def main(path: str) -> None:
    """Print the counts of the file at path."""
    passed = failed = skipped = 0
    for case in ElementTree.parse(path).getroot().iter("testcase"):
        skip = case.find("skipped")
        if case.find("failure") is not None or case.find("error") is not None:
            failed += 1
        elif skip is not None:
            skipped += 1
            name = f"{case.get('classname', '')}.{case.get('name', '')}"
            print(f"   skipped: {name}: {skip.get('message', '')}", file=sys.stderr)
        else:
            passed += 1
    print(passed, failed, skipped)


if __name__ == "__main__":
    main(sys.argv[1])
