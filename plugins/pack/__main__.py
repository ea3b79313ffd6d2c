"""`python -m quickreturn.plugins.pack FOLDER [PROBLEM...]`: make tables and bounds anew in a folder, and judge them by those of the pack.

Exit code 1: a new table is outside a bound of the pack. Where a new bound is wider than the pack's, that is told.
"""

import json
import sys
import time
from pathlib import Path

from quickreturn.pack.check import PACK, judged
from quickreturn.plugins.pack.problems import PROBLEMS, made, written


def main(folder: Path, names: list[str]) -> int:
    """Make the named problems, or all; the exit code."""
    code = 0
    for name in names or PROBLEMS:
        begun = time.monotonic()
        new = made(PROBLEMS[name])
        written(folder, name, new)
        print(f"{name}: {time.monotonic() - begun:.0f} s", flush=True)
        kept = json.loads((PACK / name / "bounds.json").read_text("utf-8"))["signals"]
        for signal, status, told in judged(name, folder / name / "results.csv"):
            bounds = [each[signal]["bound"] for each in (new[1]["signals"], kept)]
            wider = "; bound {:g}, was {:g}".format(*bounds) if bounds[0] > bounds[1] else ""
            print(f"  {signal:18} {status:18} {told}{wider}")
            code |= status != "within"
    return code


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), sys.argv[2:]))
