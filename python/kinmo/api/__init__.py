"""The public API. Users import its names from `kinmo` itself, which loads a module when one of its names is first used."""
