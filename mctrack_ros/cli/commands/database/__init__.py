"""The trajectory database: what goes in and out, questions, reports."""
