"""`python -m quickreturn` is the command `quickreturn`."""

import sys

from quickreturn.command_line import main

if __name__ == "__main__":
    sys.exit(main())
