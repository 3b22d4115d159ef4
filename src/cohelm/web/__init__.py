"""Web server of the page, HTTP and one WebSocket: the only part of cohelm that uses the network.

    GET    /  /therapist            the page; it loads nothing from other sites
    GET    /assets/*                its scripts and styles
    GET    /api/health              {"status": "ok", …}, condition of the ride; needs no sign-in
    GET    /api/me                  {"role": "driver" | "therapist", "needs_token": bool}, or 401
    POST   /api/sign-in             {"token": "…"} → {"role": …} and a cookie; 401 wrong, 429 wait
    POST   /api/sign-out            204
    POST   /api/stop                STOP without a socket; 204
    GET    /api/schema              the messages' JSON Schema; needs no sign-in
    GET    /api/floor/{digest}.png  image of the map
    GET    /api/floor/solids        heights of what stands on it, for the 3-D view
    GET    /api/limits, /api/rider  in force; PUT: the therapist; 409: try again later
    GET    /api/audit               who drove and who changed what; the therapist
    GET    /api/sessions            rides that have ended; the therapist
    GET    /api/sessions/{id}       one; with .html, .csv or .png its report, table and map
    DELETE /api/sessions            delete all
    WS     /ws                      ``live.messages``; the first is a Welcome

A refusal is {"code": "…", "text": "…"}; 429 also has ``Retry-After``. If it is opened by a link of
the form ``/#token=…``, the page signs in with that token and removes it from the address. Codes
with which a socket is closed: ``page_connections.CloseCode``.
"""
