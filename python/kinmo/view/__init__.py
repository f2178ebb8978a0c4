"""One self-contained HTML page: what was run, tables, training curves, and pictures of hits and failures."""
