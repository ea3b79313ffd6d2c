"""The subcommands of `quickreturn`, a click command each; those that belong together share a module.

A module imports nothing slow at its top: a subcommand imports what it needs when it runs, so that `--help` is instant.
"""
