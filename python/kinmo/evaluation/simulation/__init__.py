"""Tests of exported objects in physics simulators: whether they load, stay at rest, move, and agree with kinmo's kinematics."""
