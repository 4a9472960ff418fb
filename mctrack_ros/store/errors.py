"""What goes wrong with trajectory databases."""


class StoreError(RuntimeError):
    """A database that cannot be opened, written or asked; names it and the reason."""


class LeftOutWarning(UserWarning):
    """Fields of messages that a database does not keep; names the topic and the fields."""
