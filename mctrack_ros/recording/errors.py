"""What goes wrong with bags."""


class BagError(RuntimeError):
    """A bag that cannot be read or written; names the bag and the reason."""


class CutBagWarning(UserWarning):
    """A bag that breaks off is read as far as it goes; says until when."""
