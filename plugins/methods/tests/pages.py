"""A report's page with made-up results of the studies of methods."""

from typing import Any

from quickreturn.cases.comparison.engines import CaseResult
from quickreturn.plugins.methods import studies
from quickreturn.plugins.methods.map import Map
from quickreturn.reports.page.content import Content
from tests.reports import pages
from tests.reports.pages import chapter_of, finding_of, plain, read, text_of

__all__ = ["chapter_of", "finding_of", "of_studies", "one_run", "plain", "read", "text_of"]


def of_studies(**made_up: Any) -> dict[Any, Any]:
    """The data of a content with some results of studies, by name; none of the others."""
    return {
        studies.fronts_of: made_up.get("fronts", ((), None)),
        studies.hard_scenes_of: made_up.get("hard_scenes", ((), None)),
        studies.map_of: made_up.get("classes", Map()),
    }


def one_run(*results: CaseResult, **made_up: Any) -> Content:
    """A report on made-up results, those of studies by name; without any, on run 24."""
    return pages.one_run(*results, data=of_studies(**made_up))
