"""One module per subcommand of `quickreturn`, each with a click command called `command`.

A module imports nothing slow at its top: a subcommand imports what it needs when it runs, so that `--help` is instant.
"""
