"""Tables 2, 3 and 4 of the paper, and the study of sensors: networks for scans, trained with different labels."""
