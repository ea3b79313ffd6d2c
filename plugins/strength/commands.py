"""`quickreturn explain`: what happens in a turn of a machine."""

from quickreturn.commands import options
from quickreturn.commands.console import Call, ExitCode, tell, tell_slow


@options.command(
    options.case,
    options.shared(
        "--engine",
        "engines",
        metavar="E",
        default="reference",
        read=lambda _, name: [name],
        show_default=True,
        help="Engine, see `quickreturn engines`.",
    ),
    options.accuracy,
    options.assignments,
    options.of_workshop,
    options.json,
)
def explain(call: Call) -> int:
    """Say in about ten sentences what happens in a turn of CASE in its steady state, with numbers.

    Each sentence is read off the settled motion that `run` stores; none has a number whose claimed error is as large as itself. The JSON
    document is a list of objects with topic, sentence and numbers in SI. Exit code 3: the engine has no settled turn, or misses its
    accuracy.
    """
    import quickreturn as qr
    from quickreturn.arguments import settings_of

    loaded, (engine,) = call.case(), call.engines
    call.refuse_missing()
    tell_slow([loaded])
    found = qr.explain(loaded, engine, accuracy=call.accuracy, settings=settings_of(call.settings, [engine])[engine])
    call.show(found.statements, repr(found))
    if found.run.ending.delivered:
        return ExitCode.GOOD
    tell(f"{loaded.name}: engine {engine} {found.run.status}: {found.run.remark}")
    return ExitCode.ENGINE_TROUBLE
