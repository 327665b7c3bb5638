"""What the program offers."""


def commands() -> list[str]:
    """Return the names of its commands."""
    from orbitdb.cli.app import program

    known = program().registered_commands
    return [command.name or command.callback.__name__ for command in known if not command.hidden]
