# SPDX-License-Identifier: GPL-3.0-or-later
"""A coupled run as its files tell it: series, the steps that were committed, what the coupler's log says at the end."""
import dataclasses
import pathlib
import re

import numpy as np

from result_files import NothingToDraw, read_series


@dataclasses.dataclass
class CoupledRun:
    name: str
    folder: pathlib.Path  # of the coupled run: drag.csv, coupling.csv, coupler.log, a folder a participant
    root: pathlib.Path  # of all stages

    @staticmethod
    def find(root: pathlib.Path) -> "CoupledRun":
        """In the folder of a run of all stages, or of the coupled run itself."""
        found = sorted(root.rglob("coupling.csv"), key=lambda file: file.stat().st_mtime)
        if not found:
            raise NothingToDraw(f"no coupling.csv below {root}: is it the folder of a coupled run?")
        folder = found[-1].parent
        case = folder / "case.textproto"
        name = text_field(case.read_text(), "name") if case.exists() else None
        own = root.resolve().name  # says the variant, too
        return CoupledRun(own if not name or own.startswith(name) else name, folder, root)

    def drag(self) -> dict[str, np.ndarray]:
        return read_series(self.folder, "drag.csv", ["time", "force_x", "force_y", "force_z"])

    def coupling(self) -> dict[str, np.ndarray]:
        return read_series(self.folder, "coupling.csv", ["step", "iteration", "time", "residual_relative", "force_defect"])

    def structure(self) -> dict[str, np.ndarray]:
        return read_series(self.folder / "structure", "structure.csv", ["time"])

    def last_iterations(self) -> dict[str, np.ndarray]:
        """The rows of coupling.csv that ended a committed step: of attempts that were rolled back none is left."""
        rows = self.coupling()
        last = {time: row for row, time in enumerate(rows["time"])}
        committed = [last[time] for time in self.drag()["time"] if time in last]
        return {name: values[committed] for name, values in rows.items()}

    def log(self) -> str:
        file = self.folder / "coupler.log"
        return file.read_text(errors="replace") if file.exists() else ""

    def closing_lines(self) -> list[str]:
        """What the coupler said after its last step: figures, times, memory."""
        lines = [line.split("] ", 3)[-1] for line in self.log().splitlines()]
        steps = [i for i, line in enumerate(lines) if re.match(r"step \d+/\d+", line)]
        return lines[steps[-1] + 1:] if steps else []

    def warnings(self) -> list[str]:
        return [line for line in self.log().splitlines() if "[warning]" in line or "[error]" in line]

    def time_by_process(self) -> dict[str, float]:
        """Seconds, from the line `time 156.5 s: structure 30.9 s (20 %), ..., coupler and transport 7.7 s`."""
        line = next((line for line in reversed(self.closing_lines()) if line.startswith("time ")), "")
        _, _, parts = line.partition(": ")
        return {name: float(seconds) for name, seconds in re.findall(r"([a-z_ ]+?) ([\d.]+) s(?: \(\d+ %\))?(?:, |$)", parts)}

    def earlier(self) -> list[pathlib.Path]:
        """Folders of the stages before the coupled run, of the case that it goes on from first."""
        linked = self.root / "earlier"
        return [*([linked.resolve()] if linked.exists() else []), self.root]

    def configs(self) -> dict[str, str]:
        files = sorted(self.root.glob("*.textproto")) or sorted(self.folder.glob("*.textproto"))
        return {file.name: file.read_text() for file in files}


def text_field(text: str, name: str) -> str | None:
    """The first text field of that name in a config."""
    match = re.search(rf'^[^#\n]*\b{name}: *"([^"]*)"', text, re.MULTILINE)
    return match and match.group(1)
