"""Where pictures come from: cameras, bags and films, and the nodes that send them."""
