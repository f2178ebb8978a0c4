"""Networks and their training: shared layers, the training loop, trained weights, and the motion GNN of both methods."""
