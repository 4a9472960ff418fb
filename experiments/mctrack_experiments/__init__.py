"""The papers' tables and figures, real data, benchmarks."""
