"""Why a tick was decided as it was."""
