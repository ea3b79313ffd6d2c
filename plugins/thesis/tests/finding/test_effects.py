"""The effects of the study are what their file says of them."""

import pytest

from quickreturn.cases.library.thesis.runs import run_case
from quickreturn.plugins.thesis.finding.effects import Effect, effects

EFFECTS = {effect.id: effect for effect in effects()}


@pytest.mark.parametrize("effect", effects(), ids=EFFECTS)
def test_every_strength_changes_the_scene_or_the_engine(effect: Effect) -> None:
    published = run_case(24).mechanism, dict[str, str]()
    strengths = [published, *((effect.scene(24, place), effect.settings(place)) for place in range(3))]
    assert all(one != other for place, one in enumerate(strengths) for other in strengths[:place])
    assert len(effect.words) == len(effect.strengths) == 3


@pytest.mark.parametrize("effect", effects(), ids=EFFECTS)
def test_what_is_called_symmetric_is_odd_in_the_gap_and_loses_energy_at_most_in_impacts(effect: Effect) -> None:
    scene = effect.scene(24, 2)
    odd = len(set(scene.slider.sides)) == 1 and scene.gravity[1] == 0.0
    assert effect.symmetric == (odd and not scene.slider.has_friction and scene.base.friction_torque == 0.0)


def test_the_strip_of_an_alloy_has_that_alloys_modulus() -> None:
    # 10.0 and 10.6 million psi over 8.72 million psi, which the published stiffness makes of the section
    published = run_case(24).mechanism.follower.elastic_modulus
    for place, modulus in ((1, 10.0e6), (2, 10.6e6)):
        follower = EFFECTS["strip"].scene(24, place).follower
        assert follower.elastic_modulus == pytest.approx(modulus * 6894.757, rel=5e-3)  # psi in Pa; factors of four digits
        assert follower.elastic_modulus > published
