"""Part poses, amodal boxes and joints, fitted to the networks' point predictions."""
