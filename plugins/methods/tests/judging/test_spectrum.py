import numpy as np
import pytest

from quickreturn.plugins.methods.judging.conditioning import band_levels, later_differences

TIME = np.arange(0.0, 4.0005, 1e-3)


def columns(deflection: np.ndarray, energy: float = 1.0) -> dict[str, np.ndarray]:
    return {"time": TIME, "tip_deflection": deflection, "strain_energy": np.full_like(TIME, energy)}


def test_the_levels_of_a_sine_add_up_to_its_rms_in_its_band() -> None:
    levels = band_levels(3.0 * np.sin(2.0 * np.pi * 17.0 * TIME), 1e-3)
    assert np.linalg.norm(levels) == pytest.approx(3.0 / np.sqrt(2.0), rel=2e-3)  # one window over 68 periods
    assert np.max(levels) == pytest.approx(np.linalg.norm(levels), rel=1e-3)


def test_a_shift_in_time_changes_none_of_it_a_change_of_size_or_frequency_does() -> None:
    wave = np.sin(2.0 * np.pi * 17.0 * TIME)
    shifted = np.sin(2.0 * np.pi * 17.0 * TIME + 2.0)
    assert max(later_differences(columns(wave), columns(shifted), 1.0).values()) < 0.01
    larger = later_differences(columns(1.2 * wave, 1.44), columns(wave), 1.0)
    assert larger["extremes"] == pytest.approx(0.2, rel=1e-9)
    assert larger["spectrum"] == pytest.approx(0.2, rel=1e-9)
    assert larger["energy"] == pytest.approx(0.44, rel=1e-9)
    faster = later_differences(columns(np.sin(2.0 * np.pi * 34.0 * TIME)), columns(wave), 1.0)
    assert faster["spectrum"] == pytest.approx(np.sqrt(2.0), rel=1e-2)  # nothing in common


def test_only_what_comes_later_counts() -> None:
    wave = np.sin(2.0 * np.pi * 17.0 * TIME)
    wrong_before = np.where(TIME <= 1.0, 5.0, wave)
    assert later_differences(columns(wrong_before), columns(wave), 1.0) == {"extremes": 0.0, "spectrum": 0.0, "energy": 0.0}
    without_energy = {"time": TIME, "tip_deflection": wave}
    assert set(later_differences(without_energy, columns(wave), 1.0)) == {"extremes", "spectrum"}
