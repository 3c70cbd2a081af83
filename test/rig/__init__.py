"""What tests share: nodes, processes, hosts in a network, the page, and errors on simulated drives."""
