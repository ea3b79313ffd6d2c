"""A made-up inference, as the words alone would have it: the soft roller by the frequencies, not with the ring."""

from quickreturn.plugins.thesis.inference.unknowns import NAMES, PRINTED
from quickreturn.plugins.thesis.inference.weights import EXPLANATIONS, PRIORS, SETS, Inference
from quickreturn.plugins.thesis.inference.words import RINGING, VOTES

BY_FREQUENCIES = {"untold": (0.0, 0.6, 0.16, 0.05, 0.19), "tightened": (0.0, 0.16, 0.41, 0.01, 0.42)}
WITH_RING = {"untold": (0.0, 0.004, 0.001, 0.43, 0.565), "tightened": (0.0, 0.001, 0.002, 0.09, 0.907)}
PRIOR = (0.44, 0.1, 0.08, 0.12, 0.26)


def made_up_inference() -> Inference:
    of_sets = {
        name: {words: (WITH_RING if set(RINGING) <= set(votes) else BY_FREQUENCIES)[name] for words, (votes, _) in SETS.items()}
        for name in PRIORS
    }
    return Inference(
        weights={name: {"": PRIOR, **of_set} for name, of_set in of_sets.items()},
        evidence={name: dict.fromkeys(SETS, -2.0) for name in PRIORS},
        probabilities={vote: (0.1,) * len(EXPLANATIONS) for vote in VOTES},
        costs=dict.fromkeys(VOTES, (0.5, 0.4)),
        intervals=dict.fromkeys((*NAMES, "mass"), (1.22, 1.27, 1.33)),
        deciding={"a": (4.0, 0.3), "b": (1.0, 0.7)},
        rings=((70.0, 80.0, 100.0), (83.0, 86.0, 94.0), (81.0, 83.0, 91.0), (102.0, 114.0, 140.0), (104.0, 129.0, 143.0)),
        best=(tuple(PRINTED.values()),) * 3,
        errors={"pre_frequency": 0.009, "post_frequency": 0.005, "pre_amplitude": 0.5},
        judged=(1800, 2160),
    )
