"""What tests share: nodes, processes, hosts in a network, the page, and errors on simulated drives."""
import os

PACKAGE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
