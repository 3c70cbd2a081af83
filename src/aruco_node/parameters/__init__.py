"""The parameters of nodes: how they are declared, which there are, and how they change in a running node."""
