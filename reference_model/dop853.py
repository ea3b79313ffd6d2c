"""The coefficients of DOP853: order 8, error formulas of orders 5 and 3, interpolation within a step.

Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.5; from their program `dop853.f`. They are written out
here because scipy's module that has them takes 0.3 s to import.
"""

# fmt: off
from typing import Final

import numpy as np
from numpy.typing import NDArray


def _lower(rows: tuple[tuple[float, ...], ...]) -> NDArray[np.float64]:
    """The square matrix with these rows, which leave out the zeros from the diagonal on."""
    matrix = np.zeros((len(rows), len(rows)))
    for number, row in enumerate(rows):
        matrix[number, : len(row)] = row
    return matrix


#: Stages of a step; the rate at its end is the first stage of the next.
STAGES: Final = 12
#: Weights of the stages before each stage, shape (13, 13): twelve of the step, and its end.
A: Final = _lower((
    (),
    (
        0.05260015195876773,
    ),
    (
        0.0197250569845379, 0.0591751709536137,
    ),
    (
        0.02958758547680685, 0.0, 0.08876275643042054,
    ),
    (
        0.2413651341592667, 0.0, -0.8845494793282861, 0.924834003261792,
    ),
    (
        0.037037037037037035, 0.0, 0.0, 0.17082860872947386, 0.12546768756682242,
    ),
    (
        0.037109375, 0.0, 0.0, 0.17025221101954405, 0.06021653898045596, -0.017578125,
    ),
    (
        0.03709200011850479, 0.0, 0.0, 0.17038392571223998, 0.10726203044637328, -0.015319437748624402, 0.008273789163814023,
    ),
    (
        0.6241109587160757, 0.0, 0.0, -3.3608926294469414, -0.868219346841726, 27.59209969944671, 20.154067550477894, -43.48988418106996,
    ),
    (
        0.47766253643826434, 0.0, 0.0, -2.4881146199716677, -0.590290826836843, 21.230051448181193, 15.279233632882423,
        -33.28821096898486, -0.020331201708508627,
    ),
    (
        -0.9371424300859873, 0.0, 0.0, 5.186372428844064, 1.0914373489967295, -8.149787010746927, -18.52006565999696, 22.739487099350505,
        2.4936055526796523, -3.0467644718982196,
    ),
    (
        2.273310147516538, 0.0, 0.0, -10.53449546673725, -2.0008720582248625, -17.9589318631188, 27.94888452941996, -2.8589982771350235,
        -8.87285693353063, 12.360567175794303, 0.6433927460157636,
    ),
    (
        0.054293734116568765, 0.0, 0.0, 0.0, 0.0, 4.450312892752409, 1.8915178993145003, -5.801203960010585, 0.3111643669578199,
        -0.1521609496625161, 0.20136540080403034, 0.04471061572777259,
    ),
))
#: Error of order 3: weights of the step's stages and its end, shape (13,).
E3: Final = np.array([
    -0.18980075407240762, 0.0, 0.0, 0.0, 0.0, 4.450312892752409, 1.8915178993145003, -5.801203960010585, -0.4226823213237919,
    -0.1521609496625161, 0.20136540080403034, 0.02265179219836082, 0.0,
])
#: Error of order 5: weights of the step's stages and its end, shape (13,).
E5: Final = np.array([
    0.01312004499419488, 0.0, 0.0, 0.0, 0.0, -1.2251564463762044, -0.4957589496572502, 1.6643771824549864, -0.35032884874997366,
    0.3341791187130175, 0.08192320648511571, -0.022355307863886294, 0.0,
])
#: Stages that the interpolation uses: those with a weight in the step, and the step's end.
INTERPOLATED: Final = (0, *range(5, 13))


def _interpolation() -> NDArray[np.float64]:
    """Weights of the `INTERPOLATED` stages at the fraction u of a step (equation 5.17), in powers of 2 u - 1, shape (9, 8)."""
    c = A.sum(axis=1)
    powers = np.vander(2.0 * c - 1.0, 7, increasing=True).T
    conditions = np.array([*powers, A @ A @ c**3 - c**5 / 20, A @ A @ A @ A @ c - c**5 / 120])[:, INTERPOLATED]
    integrals = np.zeros((len(INTERPOLATED), 8))  # of the powers from 0 to u; the last two conditions have the right side 0
    for k in range(7):
        integrals[k, k + 1], integrals[k, 0] = 0.5 / (k + 1), 0.5 * (-1) ** k / (k + 1)
    return np.linalg.solve(conditions, integrals)


INTERPOLATION: Final = _interpolation()
