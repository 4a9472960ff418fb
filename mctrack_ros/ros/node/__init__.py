"""What every node has: life cycle, parameters, diagnostics, exceptions."""
