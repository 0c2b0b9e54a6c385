# SPDX-License-Identifier: GPL-3.0-or-later
"""Merges VERIFY lines from standard input into the table of docs/verification.md.

A row is replaced when its case and quantity are measured again; the others stay. Exit status 1 when a line is
malformed or says FAIL.
"""
import pathlib
import platform
import re
import subprocess
import sys

INTRODUCTION = """# Verification

Written by `scripts/verify`: every quantity that a verification test compares with a reference (an exact solution, a
published benchmark, or an observed order of accuracy). |ours - reference| must not exceed the tolerance; where the
reference is an interval, its centre and half width stand here. The tests beside the case names say where each
reference comes from.
"""
HEADER = "| case | quantity | ours | reference | tolerance | result | revision |"
RULE = "|---|---|---:|---:|---:|---|---|"


def machine() -> str:
    info = pathlib.Path("/proc/cpuinfo").read_text()
    model = re.search(r"model name\s*:\s*(.*)", info)
    count = len(re.findall(r"^processor\s*:", info, re.MULTILINE))
    compiler = subprocess.run(["c++", "--version"], capture_output=True, text=True).stdout.splitlines()[0]
    return f"{model[1] if model else platform.machine()}, {count} threads, {platform.system()}, {compiler}"


def git(*arguments: str) -> str:
    return subprocess.run(["git", *arguments], capture_output=True, text=True).stdout.strip()


def revision() -> str:
    changed = git("status", "--porcelain", "--untracked-files=no", "--", ".", ":!docs")
    return (git("rev-parse", "--short=8", "HEAD") or "unknown") + (" and changes" if changed else "")


def rows_of(file: pathlib.Path) -> dict[tuple[str, str], list[str]]:
    rows = {}
    for line in file.read_text().splitlines() if file.exists() else []:
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("| ") and len(cells) == 7 and line != HEADER:
            rows[cells[0], cells[1]] = cells[2:]
    return rows


def main() -> int:
    file = pathlib.Path(sys.argv[1])
    rows = rows_of(file)
    failed = False
    at = revision()
    for line in sys.stdin:
        fields = line.split()
        if len(fields) != 7 or fields[6] not in ("pass", "FAIL"):
            print(f"malformed line: {line.rstrip()}", file=sys.stderr)
            failed = True
            continue
        failed |= fields[6] == "FAIL"
        rows[fields[1], fields[2]] = fields[3:] + [at]
    table = [f"| {' | '.join([*key, *cells])} |" for key, cells in sorted(rows.items())]
    file.write_text("\n".join([INTRODUCTION, f"Last run on: {machine()}.\n", HEADER, RULE, *table]) + "\n")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
