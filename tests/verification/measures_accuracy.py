"""Accuracy of the first-mode measures on synthetic half cycles: `python -m tests.verification.measures_accuracy`."""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from quickreturn.cases.motion.first_mode import FirstMode, fit_first_modes
from quickreturn.cases.motion.number import consensus
from quickreturn.cases.motion.time_scale import TimeScale, channel_half, half_cycle, time_scale
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism, TorqueDrive
from tests.engines.scenes import INCH, POUND_FORCE, POUND_MASS, run_24
from tests.verification.synthetic import SyntheticHalf, synthetic_half

RUNS = {  # crank length (in), tip mass (lbf s^2/in), tip inertia (lbf s^2 in), crank speed (rad/s): thesis, tables 5.1 and 5.2
    6: (6.0, 2.07e-4, 1.40e-5, 11.808269),
    10: (5.0, 4.10e-5, 2.80e-6, 19.696489),
    17: (4.0, 4.10e-5, 2.80e-6, 13.910073),
    24: (4.0, 2.90e-4, 1.96e-5, 16.617773),
}
VIBRATIONS = (1.0, 0.3, 0.1, 0.03, 0.0)  # over the slow part's peak
AS_DICTATED = (1.0, 1.0)
DRIFTS = (AS_DICTATED, (0.7, 1.3))  # least and greatest drift of the frequency over that of the mechanism's own


@dataclass(frozen=True)
class Accuracy:
    """Errors at one strength of vibration, relative; NaN where nothing was resolved."""

    vibration: float  # over the slow part's peak
    samples: int  # channels of half cycles drawn
    resolvable: float  # share of them whose frequency was measured at all
    bias: float = np.nan  # mean error of the frequency
    spread: float = np.nan  # standard deviation of the frequency's error
    within: float = np.nan  # modulus of the frequency's error that 90 % stay below
    amplitude_spread: float = np.nan  # standard deviation of the amplitude's error
    claimed: float = np.nan  # median claimed uncertainty of the frequency
    rms_z: float = np.nan  # root mean square of errors over claimed uncertainties
    within_two: float = np.nan  # share of the frequencies that lie within two claimed uncertainties
    consensus_claimed: float = np.nan  # the same of the consensus frequencies
    consensus_rms_z: float = np.nan  # the same of the consensus frequencies
    consensus_within_two: float = np.nan  # the same of the consensus frequencies


def thesis_scene(run: int) -> tuple[Mechanism, float]:
    """Mechanism of a thesis run, undamped but for the crank, and its crank speed in rad/s."""
    crank_length, mass, inertia, speed = RUNS[run]
    torque = 10.0 * POUND_FORCE * INCH
    mechanism = run_24(
        crank={"length": crank_length * INCH, "drive": TorqueDrive(torque=torque, damping=torque / speed, initial_speed=speed)},
        base={"damping": 0.0},
        follower={"damping": 0.0},
        tip={"mass": mass * POUND_MASS, "inertia": inertia * POUND_FORCE * INCH},
    )
    return mechanism, speed


def accuracy(vibration: float, samples: int, seed: int, drifts: tuple[float, float] = AS_DICTATED) -> Accuracy:
    """Measure the channels of half cycles, turn by turn from every scene and half, until there are at least `samples`."""
    random = np.random.default_rng([seed, round(1000 * vibration)])
    errors, claims, amplitudes, agreed, drawn = [], [], [], [], 0
    for scale, speed, half in _turns():
        synthetic = synthetic_half(scale, half, speed, vibration, random, drift_scale=random.uniform(*drifts))
        modes = first_modes_of(scale, synthetic)
        known = [mode for mode in modes.values() if mode.frequency and mode.frequency_uncertainty]
        truth = synthetic.first_mode_frequency
        frequencies = [mode.frequency for mode in known if mode.frequency]
        uncertainties = [mode.frequency_uncertainty for mode in known if mode.frequency_uncertainty]
        errors += [frequency / truth - 1.0 for frequency in frequencies]
        claims += [uncertainty / truth for uncertainty in uncertainties]
        together = consensus(half, frequencies, uncertainties)
        if together.first_mode_frequency and together.uncertainty:
            agreed.append((together.first_mode_frequency / truth - 1.0, together.uncertainty / truth))
        amplitudes += [
            mode.amplitude / synthetic.first_mode_amplitudes[name] - 1.0
            for name, mode in modes.items()
            if mode.amplitude is not None and vibration
        ]
        drawn += len(modes)
        if drawn >= samples:
            break
    if not errors:
        return Accuracy(vibration, drawn, 0.0)
    error, claimed = np.array(errors), np.array(claims)
    common, common_claimed = np.array(agreed).T
    return Accuracy(
        vibration,
        drawn,
        error.size / drawn,
        float(error.mean()),
        float(error.std()),
        float(np.quantile(np.abs(error), 0.9)),
        float(np.std(amplitudes)) if amplitudes else np.nan,
        float(np.median(claimed)),
        *_against_claims(error, claimed),
        float(np.median(common_claimed)),
        *_against_claims(common, common_claimed),
    )


def first_modes_of(scale: TimeScale, drawn: SyntheticHalf) -> dict[str, FirstMode]:
    """The first mode in every channel of a synthetic half."""
    grid = half_cycle(scale, drawn.time[0], drawn.time[-1], CubicSpline(drawn.time, drawn.crank_angle))
    channels = {name: channel_half(scale, grid, name, CubicSpline(drawn.time, signal)) for name, signal in drawn.signals.items()}
    return fit_first_modes([channels])[0]


def _against_claims(errors: Array, claimed: Array) -> tuple[float, float]:
    """Root mean square of z, and the share within two."""
    z = errors / claimed
    return float(np.sqrt(np.mean(z**2))), float(np.mean(np.abs(z) <= 2.0))


def _turns() -> Iterator[tuple[TimeScale, float, str]]:
    scales = []
    for run in RUNS:
        mechanism, speed = thesis_scene(run)
        scale = time_scale(mechanism)
        assert scale is not None
        scales.append((scale, speed))
    while True:
        for scale, speed in scales:
            for half in ("pre", "post"):
                yield scale, speed, half


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=320, help="channels of half cycles per row (default 320)")
    parser.add_argument("--seed", type=int, default=1, help="of the random numbers (default 1)")
    arguments = parser.parse_args()
    print("                                                                                     consensus:")
    print(
        "drift     vibration  resolvable    bias  spread  90 % below  claimed  rms z  within 2  claimed  rms z  within 2  amplitude spread"
    )
    for drifts in DRIFTS:
        for vibration in VIBRATIONS if drifts == AS_DICTATED else VIBRATIONS[:3]:
            row = accuracy(vibration, arguments.samples, arguments.seed, drifts)
            print(
                f"{drifts[0]:g} to {drifts[1]:<4g}{row.vibration:8.2f}  {row.resolvable:10.1%}  {row.bias:6.2%}  {row.spread:6.2%}"
                f"  {row.within:10.2%}  {row.claimed:7.2%}  {row.rms_z:5.2f}  {row.within_two:8.1%}  {row.consensus_claimed:7.2%}"
                f"  {row.consensus_rms_z:5.2f}  {row.consensus_within_two:8.1%}  {row.amplitude_spread:16.1%}",
                flush=True,
            )


if __name__ == "__main__":
    main()
