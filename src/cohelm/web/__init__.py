"""The rider's page over HTTP and one WebSocket: the only part of cohelm that listens to a network.

    GET    /  /therapist            the page; everything it needs comes from here
    GET    /assets/*                its scripts and styles
    GET    /api/health              {"status": "ok", …}: and the ride's condition; needs no sign-in
    GET    /api/me                  {"role": "driver" | "therapist", "needs_token": bool}, or 401
    POST   /api/sign-in             {"token": "…"} → {"role": …} and a cookie; 401 wrong, 429 wait
    POST   /api/sign-out            204
    POST   /api/stop                STOP without a socket; 204
    GET    /api/schema              the messages' JSON Schema; needs no sign-in
    GET    /api/floor/{digest}.png  the map's picture
    GET    /api/limits, /api/rider  as they are; PUT: the therapist; 409 where it has to wait
    GET    /api/audit               who drove and who changed what; the therapist
    GET    /api/sessions            rides that have ended; the therapist
    GET    /api/sessions/{id}       one; with .html, .csv or .png its summary, track and map
    DELETE /api/sessions            all of them, at once
    WS     /ws                      ``live.messages``; the first is a Welcome

A refusal is {"code": "…", "text": "…"}, 429 with ``Retry-After`` besides. Under a
link of the form ``/#token=…`` the page signs in with that token and forgets the link. Codes with
which the socket is closed: ``page_connections.CloseCode``.
"""
