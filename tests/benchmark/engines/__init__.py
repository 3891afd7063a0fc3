"""One file per engine. Peers are imported when they are prepared, so that each may be missing."""
