"""Laws that hold for all inputs: few examples in every run of the suite, many where it may take longer."""

import inspect
from collections.abc import Callable

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis.strategies import SearchStrategy


def for_all(few: int, many: int, **inputs: SearchStrategy) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Turn a law into two tests: of `few` examples, and of `many` that run with the long checks. Other arguments are pytest's.

    Examples are the same in every run: what fails on one machine can be looked into on another.
    """

    def tested(law: Callable[..., None]) -> Callable[..., None]:
        sizes = [pytest.param(few, id="few"), pytest.param(many, id="many", marks=pytest.mark.verify)]

        @pytest.mark.parametrize("examples", sizes)
        def test(examples: int, **arguments: object) -> None:
            profile = settings(
                max_examples=examples,
                derandomize=True,
                database=None,
                deadline=None,  # the first example compiles
                phases=[Phase.generate],  # a smaller example of a failure would take minutes, and these can be read as they are
                suppress_health_check=[HealthCheck.too_slow],
            )
            profile(given(**inputs)(_bound(law, arguments)))()

        others = [parameter for name, parameter in inspect.signature(law).parameters.items() if name not in inputs]
        examples = inspect.Parameter("examples", inspect.Parameter.POSITIONAL_OR_KEYWORD)
        test.__name__, test.__qualname__, test.__doc__, test.__module__ = law.__name__, law.__qualname__, law.__doc__, law.__module__
        test.pytestmark = [*test.pytestmark, *getattr(law, "pytestmark", [])]  # type: ignore[attr-defined]
        test.__signature__ = inspect.Signature([examples, *others])  # type: ignore[attr-defined]
        return test

    return tested


def _bound(law: Callable[..., None], arguments: dict[str, object]) -> Callable[..., None]:
    """The law with pytest's arguments filled in; the name and source that hypothesis draws its seed from stay the law's."""
    if not arguments:
        return law
    signature = inspect.signature(law)
    drawn = signature.replace(parameters=[each for name, each in signature.parameters.items() if name not in arguments])

    def one(*values: object, **named: object) -> None:
        law(**arguments, **drawn.bind(*values, **named).arguments)

    one.__signature__ = drawn  # type: ignore[attr-defined]
    one.__name__, one.__qualname__, one.__module__ = law.__name__, law.__qualname__, law.__module__
    return one
