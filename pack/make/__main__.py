"""`python -m quickreturn.pack.make FOLDER [PROBLEM...]`: make tables and bounds anew in a folder, and judge them by those of the pack.

Exit code 1: a new table is outside a bound of the pack. Where a new bound is wider than the pack's, that is told.
"""

import json
import sys
import time
from pathlib import Path

from quickreturn.pack.check import PACK, BadInput, judged
from quickreturn.pack.make.bounds import made, written
from quickreturn.pack.make.problems import PROBLEMS


def main(folder: Path, names: list[str]) -> int:
    """Make the named problems, or all; the exit code."""
    code = 0
    for name in names or PROBLEMS:
        begun = time.monotonic()
        new = made(PROBLEMS[name])
        written(folder, name, new)
        print(f"{name}: {time.monotonic() - begun:.0f} s", flush=True)
        try:
            kept = json.loads((PACK / name / "bounds.json").read_text("utf-8"))["signals"]
            verdicts = {each.signal: each for each in judged(name, folder / name / "results.csv")}
        except (OSError, BadInput) as missing:
            print(f"  not compared: {missing}")
            continue
        for signal, each in new[1]["signals"].items():
            wider = f"; bound {each['bound']:g}, was {kept[signal]['bound']:g}" if each["bound"] > kept[signal]["bound"] else ""
            print(f"  {signal:18} {verdicts[signal].status:18} {verdicts[signal].told}{wider}")
        code |= any(each.status != "within" for each in verdicts.values())
    return code


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), sys.argv[2:]))
