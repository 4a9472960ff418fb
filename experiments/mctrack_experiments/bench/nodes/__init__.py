"""Running nodes: killed, replayed, watched for hours."""
