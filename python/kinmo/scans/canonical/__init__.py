"""Articulated objects in canonical form: closed joints, a visible base, and one order of parts for a whole category."""
