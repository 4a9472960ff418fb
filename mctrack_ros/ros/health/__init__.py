"""What `/diagnostics` says of streams, of tracking, of recording and of processes."""
