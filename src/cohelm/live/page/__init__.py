"""Translation between pages and the ride: commands in, states, routes and previews out."""
