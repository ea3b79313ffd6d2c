"""Published inconsistencies."""

from quickreturn.cases.library.thesis.inconsistencies import inconsistencies
from quickreturn.plugins.thesis.chapters.inconsistencies import finding, inconsistency_table
from tests.reports.pages import finding_of, one_run, plain


def test_the_heading_counts_them() -> None:
    assert plain(finding(1)) == "1 contradiction or gap in the published data, none corrected silently"
    assert plain(finding(6)) == "6 contradictions and gaps in the published data, none corrected silently"
    assert finding_of(one_run(), "inconsistencies").startswith(f"{len(inconsistencies())} contradictions and gaps")


def test_each_is_listed_with_its_runs() -> None:
    found = inconsistencies()
    rows = inconsistency_table(found).rows
    assert [row["what"].value for row in rows] == [each.what for each in found]
    assert "all" in {row["runs"].value for row in rows}
