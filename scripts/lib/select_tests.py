# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads `ctest --show-only=json-v1` from standard input and prints, as one regular expression, the names of the
verification tests that the arguments select: a group (a label, or the start of a name) or the start of a name.
Without arguments all of them. Exit status 2 when an argument selects nothing."""
import json
import sys


def labels_of(test: dict) -> list[str]:
    return next((p["value"] for p in test.get("properties", []) if p["name"] == "LABELS"), [])


tests = {test["name"]: labels_of(test) for test in json.load(sys.stdin)["tests"]}
tests = {name: labels for name, labels in tests.items() if "verification" in labels}
selected = set() if sys.argv[1:] else set(tests)
for argument in sys.argv[1:]:
    matching = {name for name, labels in tests.items() if name.startswith(argument) or argument in labels}
    if not matching:
        sys.exit(f"verify: nothing is called {argument}; there are: {' '.join(sorted(tests))}")
    selected |= matching
print("^(" + "|".join(sorted(selected)) + ")$")
