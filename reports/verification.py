"""Results of the long verification for the report, from the store's folder.

The file `verification.json` holds {"code": fingerprint of the code, "date": text, "chapters": [{"title", "text", "columns": [text],
"rows": [[text or number or null]]}]}. The report shows it as long as the code is unchanged.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from quickreturn.cases.running.key import code_fingerprint

FILE: Final = "verification.json"
#: The code that the verification depends on.
PARTS: Final = ("quickreturn.reference_model", "quickreturn.engines", "quickreturn.cases")


@dataclass(frozen=True)
class Verification:
    """The stored verification."""

    chapters: tuple[dict[str, Any], ...] = ()  # in the form above
    date: str = ""
    absent: str = ""  # why there is none (a sentence), or ""


def verification(folder: Path) -> Verification:
    """The verification in the store's folder."""
    try:
        document = json.loads((folder / FILE).read_text("utf-8"))
        stored = Verification(tuple(document["chapters"]), document["date"])
    except FileNotFoundError:
        return Verification(absent="It has not been run with this store.")
    except (OSError, ValueError, KeyError, TypeError):
        return Verification(absent=f"{FILE} in the store cannot be read.")
    if document.get("code") != code_fingerprint(PARTS):
        return Verification(absent="Its stored results were made with other code than this page, so they are not shown.")
    return stored
