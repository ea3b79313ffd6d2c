"""What the command line tests share is at hand here, too."""

from tests.quickreturn.conftest import Answer, Call, call, own_store, warm_workers

__all__ = ["Answer", "Call", "call", "own_store", "warm_workers"]
