"""What the program offers."""


def commands() -> list[str]:
    """Return the names of its commands."""
    from orbitdb.cli.app import app

    return [
        command.name or command.callback.__name__ for command in app.registered_commands if not command.hidden
    ]
