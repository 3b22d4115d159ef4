"""The page: cohelm.driving over HTTP and one WebSocket, and the built front end."""
