"""What the program offers."""


def commands() -> list[str]:
    """Return the names of its commands."""
    from orbitdb.cli.app import program

    known = [command for command in program().registered_commands if not command.hidden]
    return [command.name or str(getattr(command.callback, "__name__", "")) for command in known]
