"""Parts that several families share: handles, knobs, buttons, feet, panels, locks.

In all functions `draw` is the source of random values. Functions named `add_...` add nodes below the node `above`.
"""
