"""How far a source of messages is written."""

from __future__ import annotations

from alembic import op
from sqlalchemy import BigInteger, Column, Integer, String

revision = '0002_progress'
down_revision = '0001'


def upgrade() -> None:
    """Make the table."""
    op.create_table(
        'progress',
        Column('source', String(200), primary_key=True),
        Column('position', BigInteger, nullable=False),
        Column('run_id', Integer, nullable=False),
    )


def downgrade() -> None:
    """Remove the table."""
    op.drop_table('progress')
