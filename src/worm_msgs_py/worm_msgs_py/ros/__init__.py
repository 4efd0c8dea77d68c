"""The contract on the wire: quality of service, counting publishers, and the base of all nodes."""
