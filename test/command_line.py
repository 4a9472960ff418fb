"""`mctrack` with arguments, in this process: a start of Python costs more than most commands."""

import contextlib
import io
import sys
import warnings
from unittest import mock

from mctrack_ros.cli.main import main


def mctrack(*arguments):
    """Run the command line as a user does; return exit code, output and errors."""
    output, errors, code = io.StringIO(), io.StringIO(), 0
    with (
        mock.patch.object(sys, 'argv', ['mctrack', *map(str, arguments)]),
        contextlib.redirect_stdout(output),
        contextlib.redirect_stderr(errors),
        warnings.catch_warnings(),
    ):
        warnings.simplefilter('default', UserWarning)
        try:
            main()
        except SystemExit as ended:
            code = ended.code or 0
    return code, output.getvalue(), errors.getvalue()
