"""One writer a layout. Each writes one object into a folder that does not exist yet."""
