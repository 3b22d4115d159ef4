"""Alternative routes, their features, and a rider's learned preference among them."""
