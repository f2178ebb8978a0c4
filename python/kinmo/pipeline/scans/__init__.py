"""The stages of what sees scans: each object scanned, networks trained, judged and shown, and the tables of that."""
