"""The silhouettes paper on the simulated car park."""
