"""What the first screen says of the user's own machine, for made-up loads."""

from quickreturn.plugins.strength.case_loads import CaseLoads
from quickreturn.plugins.strength.page import machine_screen, safety_figure
from quickreturn.plugins.strength.tests.made_up_loads import made_up_loads, with_resonance, without
from tests.reports.pages import plain


def test_a_machine_has_its_verdict_its_stress_and_its_warning() -> None:
    case = made_up_loads()
    screen = machine_screen(case, case.case.units)
    found = plain(" ".join(screen.sentences))
    share = 100.0 * 0.375 / case.case.mechanism.follower.length
    assert all(each in found for each in ("The arm holds", "2 (± 5.0 %)", "3 (± 3.0 %)", "375 mm from P", f"{share:.0f} %", "324°"))
    assert (screen.title, screen.warning) == (case.case.title, "")
    numbers = {plain(number): plain(meaning) for number, meaning in screen.figures}
    assert "compression, 0.05000 MPa" in numbers["12.35 MPa"]
    assert "yielding at 240 MPa; 3 against fatigue" in numbers["2"]
    assert "18.40 Hz" in numbers["9.20"]
    missed = machine_screen(with_resonance(case, missed=("a misses it", "b misses it")), case.case.units)
    assert "a misses it; b misses it." in missed.warning
    nothing = machine_screen(CaseLoads(case.result, {}), case.case.units)
    assert "Provenance" in nothing.sentences[0]
    assert nothing.figures == []


def test_the_safety_figure_gives_the_factors_that_are_known() -> None:
    case = made_up_loads()
    assert [safety_figure(without(case, factor))[0] for factor in ("fatigue_factor", "yield_factor")] == ["2", "3"]
    both, given = ("yield_factor", "fatigue_factor"), ("yield_strength", "fatigue_strength")
    for unknown in (0, 1, 2):
        number, meaning = safety_figure(without(case, *both[:unknown]))
        assert [key in meaning for key in given] == [place < unknown for place in (0, 1)]
        assert (number == "–") == (unknown == 2)
