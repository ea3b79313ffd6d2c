"""Speed against error: every method over its ladder of settings, on a few scenes, against a confirmed solution."""

from quickreturn.plugins.methods.benchmark.compiling import Compiling, compiling
from quickreturn.plugins.methods.benchmark.measurement import Benchmark, benchmark
from quickreturn.plugins.methods.benchmark.scenes import SCENES, measure, stored

__all__ = ["SCENES", "Benchmark", "Compiling", "benchmark", "compiling", "measure", "stored"]
