"""Results of the long verification, as it leaves them in the store's folder for the report.

The file `verification.json` holds {"code": fingerprint of the code, "date": text, "chapters": [{"title", "text", "columns": [text],
"rows": [[text or number or null]]}]}. It is shown as long as the code is what it was made with.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from quickreturn.cases.jobs.key import code_fingerprint

FILE: Final = "verification.json"
#: What the verification verifies.
PARTS: Final = ("reference_model", "engines", "cases")


@dataclass(frozen=True)
class Verification:
    """What is there to show: `chapters` as described above, or why there are none."""

    chapters: tuple[dict[str, Any], ...] = ()
    date: str = ""
    absent: str = ""


def verification(folder: Path) -> Verification:
    """What the store's folder has to tell."""
    try:
        document = json.loads((folder / FILE).read_text("utf-8"))
        found = Verification(tuple(document["chapters"]), document["date"])
    except FileNotFoundError:
        return Verification(absent="It has not been run with this store.")
    except (OSError, ValueError, KeyError, TypeError):
        return Verification(absent=f"{FILE} in the store cannot be read.")
    if document.get("code") != code_fingerprint(PARTS):
        return Verification(absent="Its stored results were made with other code than this page, so they are not shown.")
    return found
